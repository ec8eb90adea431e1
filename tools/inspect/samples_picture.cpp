#include "tools/inspect/samples_picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "tools/inspect/drawing.hpp"

namespace inspect {
namespace {

using vps::SurfacePoint;
using vps::TreeSphere;

// Layout, chosen by eye, as are kFill and kLargestAreaRatio.
constexpr int kPanel_px = 560;
constexpr int kGap_px = 24;
constexpr int kHead_px = 64;
constexpr int kLegend_px = 170;
constexpr double kFill = 0.92;             // of a panel
constexpr double kLargestAreaRatio = 2.0;  // upper end of the colour scale, over the mean area

// Lambert's cosine law with light from the viewer's upper left, over 35 % ambient light.
double Shade(const View& view, const glm::dvec3& outward) {
  const glm::dvec3 light = glm::normalize(view.toward + 0.5 * view.up - 0.4 * view.right);
  return 0.35 + 0.65 * std::max(0.0, glm::dot(light, outward));
}

// Points that face the viewer, nearest last.
std::vector<const SurfacePoint*> FindFacing(const std::vector<SurfacePoint>& points, const View& view) {
  std::vector<const SurfacePoint*> seen;
  for (const SurfacePoint& point : points) {
    if (glm::dot(point.outward, view.toward) > 0.0) seen.push_back(&point);
  }
  std::stable_sort(seen.begin(), seen.end(), [&](const SurfacePoint* a, const SurfacePoint* b) {
    return glm::dot(a->p_m, view.toward) < glm::dot(b->p_m, view.toward);
  });
  return seen;
}

// 0.6 of the mean spacing sqrt(area / points), in pixels: dots overlap a little and hide what lies behind.
double DotRadius(const std::vector<SurfacePoint>& points, const vps::Box& box, double pixels_per_m) {
  double area = 0.0;
  for (const SurfacePoint& point : points) area += point.area_m2;
  if (area == 0.0) {
    const glm::dvec3 s = box.upper - box.lower;
    area = 2.0 * (s.x * s.y + s.y * s.z + s.z * s.x);
  }
  const double spacing = std::sqrt(area / static_cast<double>(std::max<std::size_t>(points.size(), 1)));
  return std::clamp(0.6 * spacing * pixels_per_m, 0.6, 7.0);
}

std::string Count(std::size_t n, const char* what) {
  return std::to_string(n) + " " + what;
}

}  // namespace

core::Result<picture::Image> DrawPoints(const std::string& title, const std::vector<SurfacePoint>& points,
                                        const vps::Box& box) {
  auto canvas = Canvas::Create(2 * kPanel_px + 3 * kGap_px + kLegend_px, 2 * (kPanel_px + kGap_px) + kHead_px + 30);
  if (!canvas) return tl::unexpected(canvas.error());
  double sum = 0.0, least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (const SurfacePoint& point : points) {
    sum += point.area_m2;
    least = std::min(least, point.area_m2);
    most = std::max(most, point.area_m2);
  }
  const double mean = sum / static_cast<double>(std::max<std::size_t>(points.size(), 1));
  const bool has_areas = sum > 0.0;
  canvas->Text(title + ": " + Count(points.size(), "points"), kGap_px, 8, kInk, true);
  constexpr const char* kNames[4] = {"from +z: x right, y up", "from -y: x right, z up", "from +x: y right, z up",
                                     "at a slant"};
  constexpr int kDirections[4] = {2, 1, 0, 3};
  for (int i = 0; i < 4; ++i) {
    const int x0 = kGap_px + (i % 2) * (kPanel_px + kGap_px);
    const int y0 = kHead_px + (i / 2) * (kPanel_px + kGap_px + 20);
    View view = MakeView(kDirections[i]);
    Fit(box, x0 + 0.5 * kPanel_px, y0 + 0.5 * kPanel_px, kFill * kPanel_px, &view);
    const double radius = DotRadius(points, box, view.pixels_per_m);
    for (const SurfacePoint* point : FindFacing(points, view)) {
      const glm::dvec2 at = view.Pixel(point->p_m);
      const Color color = has_areas ? Ramp(point->area_m2 / (kLargestAreaRatio * mean)) : Color{86, 140, 200};
      const Color shaded = Mix({20, 22, 30}, color, Shade(view, point->outward));
      canvas->Dot(at.x, at.y, radius, shaded);
    }
    canvas->Frame(x0, y0, x0 + kPanel_px, y0 + kPanel_px, kGrey);
    canvas->Text(kNames[i], x0, y0 - 22);
    canvas->ScaleBar(x0 + 14, y0 + kPanel_px - 20, kPanel_px, view.pixels_per_m);
  }
  if (has_areas) {
    const int x = 2 * kPanel_px + 3 * kGap_px;
    char text[64];
    canvas->Text("area of a point", x, kHead_px + 10);
    std::snprintf(text, sizeof text, "%.3g mm\xc2\xb2", 1e6 * kLargestAreaRatio * mean);
    canvas->ColorBar(x, kHead_px + 44, 240, Ramp, "0", text);
    std::snprintf(text, sizeof text, "mean %.3g mm\xc2\xb2", 1e6 * mean);
    canvas->Text(text, x, kHead_px + 310);
    std::snprintf(text, sizeof text, "%.2g to %.2g of it", least / mean, most / mean);
    canvas->Text(text, x, kHead_px + 332);
  }
  return std::move(canvas->image);
}

core::Result<picture::Image> DrawTree(const std::string& title, const std::vector<std::vector<TreeSphere>>& levels,
                                      const std::vector<SurfacePoint>& points, const vps::Box& box) {
  constexpr int kColumns = 3;
  const int rows = std::max(1, (static_cast<int>(levels.size()) + kColumns - 1) / kColumns);
  auto canvas =
      Canvas::Create(kColumns * (kPanel_px + kGap_px) + kGap_px, rows * (kPanel_px + kGap_px + 20) + kHead_px);
  if (!canvas) return tl::unexpected(canvas.error());
  canvas->Text(title + ": " + Count(levels.size(), "levels"), kGap_px, 8, kInk, true);
  for (std::size_t level = 0; level < levels.size(); ++level) {
    const int x0 = kGap_px + static_cast<int>(level % kColumns) * (kPanel_px + kGap_px);
    const int y0 = kHead_px + static_cast<int>(level / kColumns) * (kPanel_px + kGap_px + 20);
    View view = MakeView(3);
    Fit(box, x0 + 0.5 * kPanel_px, y0 + 0.5 * kPanel_px, 0.84 * kPanel_px, &view);
    const double radius = std::min(1.2, DotRadius(points, box, view.pixels_per_m));
    for (const SurfacePoint* point : FindFacing(points, view)) {
      const glm::dvec2 at = view.Pixel(point->p_m);
      canvas->Dot(at.x, at.y, radius, Mix({150, 154, 160}, {225, 226, 228}, Shade(view, point->outward)));
    }
    std::vector<TreeSphere> spheres = levels[level];
    std::stable_sort(spheres.begin(), spheres.end(), [&](const TreeSphere& a, const TreeSphere& b) {
      return glm::dot(a.centre_m, view.toward) < glm::dot(b.centre_m, view.toward);
    });
    double mean_radius = 0.0, largest = 0.0;
    for (const TreeSphere& sphere : spheres) {
      mean_radius += sphere.radius_m / static_cast<double>(spheres.size());
      largest = std::max(largest, sphere.radius_m);
    }
    for (const TreeSphere& sphere : spheres) {
      const glm::dvec2 at = view.Pixel(sphere.centre_m);
      const Color color = Ramp(0.85 * sphere.radius_m / largest);
      const double share = spheres.size() > 400 ? 0.45 : 0.9;
      canvas->Circle(at.x, at.y, sphere.radius_m * view.pixels_per_m, color, share);
    }
    // Clears what is drawn beyond the panel, into its neighbours.
    canvas->FillBox(x0 - kGap_px, y0 - 24, x0, y0 + kPanel_px + kGap_px, kPaper);
    canvas->FillBox(x0 + kPanel_px, y0 - 24, x0 + kPanel_px + kGap_px, y0 + kPanel_px + kGap_px, kPaper);
    canvas->Frame(x0, y0, x0 + kPanel_px, y0 + kPanel_px, kGrey);
    canvas->Text("level " + std::to_string(level) + ": " + Count(spheres.size(), "spheres") + ", mean radius " +
                     Length(mean_radius),
                 x0, y0 - 22);
    canvas->ScaleBar(x0 + 14, y0 + kPanel_px - 20, kPanel_px, view.pixels_per_m);
  }
  return std::move(canvas->image);
}

}  // namespace inspect
