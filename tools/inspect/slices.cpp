#include "tools/inspect/slices.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tools/inspect/drawing.hpp"

namespace inspect {
namespace {

// Layout and colours, chosen by eye.
constexpr int kPanel_px = 640;
constexpr int kGap_px = 24;
constexpr int kHead_px = 64;
constexpr int kLegend_px = 190;
constexpr Color kCrease{214, 39, 160};
constexpr Color kBrick{110, 114, 120};
constexpr Color kNoGrid{228, 228, 226};

// Blue outside, orange inside, pale at the surface.
Color DistanceColor(double distance_over_range) {
  const double t = std::clamp(distance_over_range, -1.0, 1.0);
  constexpr Color kPale{246, 246, 240};
  return t < 0.0 ? Mix(kPale, {214, 96, 26}, std::pow(-t, 0.7)) : Mix(kPale, {44, 110, 180}, std::pow(t, 0.7));
}

bool IsInGrid(const FieldView& field, const glm::dvec3& p) {
  return glm::all(glm::greaterThanEqual(p, field.box.lower)) && glm::all(glm::lessThanEqual(p, field.box.upper));
}

struct Panel {
  View view;
  int x0 = 0, y0 = 0;
  double range_m = 1.0, step_m = 1.0;
};

// The field at the centres of the panel's pixels and of one row and column more.
std::vector<FieldPlace> Sample(const FieldView& field, const Panel& panel) {
  std::vector<FieldPlace> places;
  places.reserve(static_cast<std::size_t>(kPanel_px + 1) * (kPanel_px + 1));
  for (int y = 0; y <= kPanel_px; ++y) {
    for (int x = 0; x <= kPanel_px; ++x) {
      places.push_back(field.at(panel.view.Point(panel.x0 + x + 0.5, panel.y0 + y + 0.5)));
    }
  }
  return places;
}

void DrawPanel(const FieldView& field, const Panel& panel, Canvas* canvas) {
  const std::vector<FieldPlace> places = Sample(field, panel);
  const double voxel_px = field.voxel_size_m * panel.view.pixels_per_m;
  const auto at = [&](int x, int y) -> const FieldPlace& {
    return places[static_cast<std::size_t>(y) * (kPanel_px + 1) + static_cast<std::size_t>(x)];
  };
  for (int y = 0; y < kPanel_px; ++y) {
    for (int x = 0; x < kPanel_px; ++x) {
      const FieldPlace& here = at(x, y);
      Color color = DistanceColor(here.distance_m / panel.range_m);
      if (here.is_crease) color = Mix(color, kCrease, 0.45);
      bool is_iso = false, is_brick = false, is_cell = false;
      for (const FieldPlace* next : {&at(x + 1, y), &at(x, y + 1)}) {
        is_iso = is_iso || std::floor(next->distance_m / panel.step_m) != std::floor(here.distance_m / panel.step_m);
        const bool any_fine = here.is_fine || next->is_fine;
        is_brick = is_brick || (any_fine && (next->voxel >> 3) != (here.voxel >> 3));
        is_cell = is_cell || next->voxel != here.voxel;
      }
      if (is_cell && voxel_px >= 10.0) color = Mix(color, kBrick, 0.18);
      if (is_brick && voxel_px >= 1.0) color = Mix(color, kBrick, 0.6);
      if (is_iso) color = Mix(color, kInk, 0.35);
      if (!IsInGrid(field, panel.view.Point(panel.x0 + x + 0.5, panel.y0 + y + 0.5))) color = kNoGrid;
      canvas->Set(panel.x0 + x, panel.y0 + y, color);
    }
  }
  // The surface is drawn last and two pixels wide, so that nothing covers it.
  for (int y = 0; y < kPanel_px; ++y) {
    for (int x = 0; x < kPanel_px; ++x) {
      const bool is_inside = at(x, y).distance_m < 0.0;
      if ((at(x + 1, y).distance_m < 0.0) == is_inside && (at(x, y + 1).distance_m < 0.0) == is_inside) continue;
      canvas->FillBox(panel.x0 + x, panel.y0 + y, std::min(panel.x0 + x + 2, panel.x0 + kPanel_px),
                      std::min(panel.y0 + y + 2, panel.y0 + kPanel_px), kInk);
    }
  }
  canvas->Frame(panel.x0, panel.y0, panel.x0 + kPanel_px, panel.y0 + kPanel_px, kGrey);
  canvas->ScaleBar(panel.x0 + 14, panel.y0 + kPanel_px - 20, kPanel_px, panel.view.pixels_per_m);
}

void DrawLegend(const Panel& whole, const Panel& close, int x, Canvas* canvas) {
  int y = kHead_px + 20;
  const auto bar = [&](const Panel& panel, const std::string& name) {
    canvas->Text(name, x, y);
    canvas->ColorBar(
        x, y + 28, 200, [&](double t) { return DistanceColor(2.0 * t - 1.0); }, "-" + Length(panel.range_m),
        "+" + Length(panel.range_m));
    canvas->Text("0", x + 24, y + 120);
    canvas->Text("lines every", x, y + 238);
    canvas->Text(Length(panel.step_m), x, y + 256);
    y += 310;
  };
  bar(whole, "distance, slices");
  bar(close, "distance, close-up");
  const auto entry = [&](const Color& color, double share, const std::string& name) {
    canvas->FillBox(x, y, x + 18, y + 14, color, share);
    canvas->Text(name, x + 26, y - 2);
    y += 24;
  };
  entry(kInk, 1.0, "surface");
  entry(kCrease, 0.45, "crease cell");
  entry(kBrick, 0.6, "brick border");
  entry(kNoGrid, 1.0, "beyond the grid");
}

}  // namespace

FieldView ViewOf(const vps::DistanceField& field) {
  const vps::Box box{field.origin_m, field.origin_m + field.voxel_size_m * glm::dvec3(field.nx, field.ny, field.nz)};
  return {"distance field of fast", field.voxel_size_m, box, [&field](const glm::dvec3& p_m) {
            const glm::dvec3 p = (p_m - field.origin_m) / field.voxel_size_m;
            const vps::FieldSample sample = vps::SampleField(field, glm::vec3(p));
            const glm::ivec3 n(field.nx, field.ny, field.nz);
            const glm::ivec3 c = glm::clamp(glm::ivec3(glm::floor(p)), glm::ivec3(0), n - 1);
            const glm::ivec3 b = c >> 3;
            const std::size_t slot = (static_cast<std::size_t>(b.z) * (n.y >> 3) + b.y) * (n.x >> 3) + b.x;
            const std::uint32_t word = field.words[field.bricks[slot] + vps::WordInBrick(c.x, c.y, c.z)];
            FieldPlace place;
            place.distance_m = sample.distance * field.voxel_size_m;
            place.is_crease = vps::KindOf(word) == vps::CellKind::kCrease;
            place.is_fine = field.bricks[slot] != 0;
            place.voxel = c;
            return place;
          }};
}

FieldView ViewOf(const vps::Voxmap& map) {
  const vps::Box box{map.origin_m, map.origin_m + map.voxel_size_m * glm::dvec3(map.nx, map.ny, map.nz)};
  return {"voxelmap of paper", map.voxel_size_m, box, [&map](const glm::dvec3& p_m) {
            const glm::ivec3 c(glm::floor((p_m - map.origin_m) / map.voxel_size_m));
            const glm::ivec3 q = glm::clamp(c, glm::ivec3(0), glm::ivec3(map.nx, map.ny, map.nz) - 1);
            FieldPlace place;
            // A point in a surface voxel (layer 0) is in contact, so the quarter makes its distance negative too.
            place.distance_m = -(map.at(q.x, q.y, q.z) + 0.25) * map.voxel_size_m;
            place.is_fine = false;  // no bricks
            place.voxel = c;
            return place;
          }};
}

core::Result<picture::Image> DrawSlices(const FieldView& field, const vps::Box& box, const CloseUp& close_up) {
  const int width = 2 * kPanel_px + 3 * kGap_px + kLegend_px;
  const int height = 2 * (kPanel_px + kGap_px + kHead_px / 2) + kHead_px / 2;
  auto canvas = Canvas::Create(width, height);
  if (!canvas) return tl::unexpected(canvas.error());
  vps::Box around = box;
  const glm::dvec3 size = box.upper - box.lower;
  const double margin_m = 0.06 * std::max({size.x, size.y, size.z}) + 2.0 * field.voxel_size_m;
  around.lower = glm::max(around.lower - margin_m, field.box.lower);
  around.upper = glm::min(around.upper + margin_m, field.box.upper);
  const glm::dvec3 centre = 0.5 * (box.lower + box.upper);

  Panel panel;
  double deepest_m = std::max(4.0 * field.voxel_size_m, 0.04 * std::max({size.x, size.y, size.z}));
  for (int k = 0; k < 40 * 40 * 40; ++k) {
    const glm::dvec3 u = (glm::dvec3(k % 40, k / 40 % 40, k / 1600) + 0.5) / 40.0;
    deepest_m = std::max(deepest_m, -field.at(around.lower + u * (around.upper - around.lower)).distance_m);
  }
  panel.range_m = deepest_m;
  panel.step_m = RoundStep(deepest_m / 4.0);
  const int left[2] = {kGap_px, 2 * kGap_px + kPanel_px};
  const int top[2] = {kHead_px, kHead_px + kPanel_px + kGap_px + kHead_px / 2};
  canvas->Text(field.title + ", voxels of " + Length(field.voxel_size_m), kGap_px, 8, kInk, true);
  constexpr const char* kAxes[3] = {"x", "y", "z"};
  constexpr int kDirection[3] = {2, 1, 0};
  constexpr const char* kSeen[3] = {"x right, y up", "x right, z up", "y right, z up"};
  for (int i = 0; i < 3; ++i) {
    panel.x0 = left[i % 2];
    panel.y0 = top[i / 2];
    panel.view = MakeView(kDirection[i]);
    Fit(around, panel.x0 + 0.5 * kPanel_px, panel.y0 + 0.5 * kPanel_px, kPanel_px, &panel.view);
    const int axis = 2 - i;
    canvas->Text(std::string("slice at ") + kAxes[axis] + " = " + Length(centre[axis]) + " (" + kSeen[i] + ")",
                 panel.x0, panel.y0 - 22);
    DrawPanel(field, panel, &*canvas);
  }
  const Panel whole = panel;
  panel.x0 = left[1];
  panel.y0 = top[1];
  // The view is along the axis with the smallest component of the normal.
  const glm::dvec3 across = glm::abs(close_up.across);
  const int along = across.z <= across.x && across.z <= across.y ? 0 : (across.y <= across.x ? 1 : 2);
  panel.view = MakeView(kDirection[along]);
  constexpr double kCloseVoxels = 32.0;  // side of the close-up; chosen by eye: cells and the band are both visible
  panel.view.centre_m = close_up.centre_m;
  panel.view.pixels_per_m = kPanel_px / (kCloseVoxels * field.voxel_size_m);
  panel.view.x = panel.x0 + 0.5 * kPanel_px;
  panel.view.y = panel.y0 + 0.5 * kPanel_px;
  panel.range_m = 8.0 * field.voxel_size_m;
  panel.step_m = field.voxel_size_m;
  const glm::dvec3& at = close_up.centre_m;
  canvas->Text("close-up at (" + Length(at.x) + ", " + Length(at.y) + ", " + Length(at.z) + "), " + kSeen[along],
               panel.x0, panel.y0 - 22);
  DrawPanel(field, panel, &*canvas);
  DrawLegend(whole, panel, 2 * kPanel_px + 3 * kGap_px, &*canvas);
  return std::move(canvas->image);
}

}  // namespace inspect
