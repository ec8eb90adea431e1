#include "tools/inspect/drawing.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace inspect {
namespace {

// Chosen by eye.
constexpr int kSmall_px = 15;
constexpr int kTitle_px = 19;

}  // namespace

Color Mix(const Color& a, const Color& b, double share) {
  Color mixed{};
  for (std::size_t k = 0; k < 3; ++k) {
    mixed[k] = static_cast<std::uint8_t>(std::lround(a[k] + std::clamp(share, 0.0, 1.0) * (b[k] - a[k])));
  }
  return mixed;
}

Color Ramp(double t) {
  constexpr std::array<Color, 5> kStops{{{68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}}};
  const double at = std::clamp(t, 0.0, 1.0) * (kStops.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
  return Mix(kStops[i], kStops[i + 1], at - static_cast<double>(i));
}

double RoundStep(double x) {
  const double power = std::pow(10.0, std::floor(std::log10(x)));
  for (const double digit : {5.0, 2.0}) {
    if (digit * power <= x) return digit * power;
  }
  return power;
}

std::string Length(double length_m) {
  char text[32];
  std::snprintf(text, sizeof text, std::abs(length_m) < 1.0 ? "%.3g mm" : "%.3g m",
                std::abs(length_m) < 1.0 ? 1e3 * length_m : length_m);
  return text;
}

View MakeView(int direction) {
  View view;
  if (direction == 0) {
    view.right = {0, 1, 0};
    view.up = {0, 0, 1};
    view.toward = {1, 0, 0};
  } else if (direction == 1) {
    view.up = {0, 0, 1};
    view.toward = {0, -1, 0};
  } else if (direction == 3) {
    view.right = glm::normalize(glm::dvec3(0.85, 0.53, 0.0));
    view.toward = glm::normalize(glm::dvec3(0.45, -0.72, 0.55));
    view.up = glm::cross(view.toward, view.right);
  }
  return view;
}

void Fit(const vps::Box& box, double x, double y, double side_px, View* view) {
  view->centre_m = 0.5 * (box.lower + box.upper);
  const glm::dvec3 half = 0.5 * (box.upper - box.lower);
  const double wide = glm::dot(glm::abs(view->right), half);
  const double high = glm::dot(glm::abs(view->up), half);
  view->pixels_per_m = 0.5 * side_px / std::max({wide, high, 1e-12});
  view->x = x;
  view->y = y;
}

core::Result<Canvas> Canvas::Create(int width, int height) {
  auto small = picture::GlyphAtlas::Create(kSmall_px);
  if (!small) return tl::unexpected(small.error());
  auto title = picture::GlyphAtlas::Create(kTitle_px, true);
  if (!title) return tl::unexpected(title.error());
  Canvas canvas(std::move(*small), std::move(*title));
  canvas.image = picture::Image(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      std::uint8_t* pixel = canvas.image.Pixel(x, y);
      std::copy(kPaper.begin(), kPaper.end(), pixel);
      pixel[3] = 255;
    }
  }
  return canvas;
}

void Canvas::Set(int x, int y, const Color& color, double share) {
  if (x < 0 || y < 0 || x >= image.width || y >= image.height) return;
  std::uint8_t* pixel = image.Pixel(x, y);
  const Color mixed = Mix({pixel[0], pixel[1], pixel[2]}, color, share);
  std::copy(mixed.begin(), mixed.end(), pixel);
}

void Canvas::FillBox(int x0, int y0, int x1, int y1, const Color& color, double share) {
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) Set(x, y, color, share);
  }
}

void Canvas::Frame(int x0, int y0, int x1, int y1, const Color& color) {
  FillBox(x0, y0, x1, y0 + 1, color);
  FillBox(x0, y1 - 1, x1, y1, color);
  FillBox(x0, y0, x0 + 1, y1, color);
  FillBox(x1 - 1, y0, x1, y1, color);
}

// Antialiased: a pixel's coverage is radius + 1/2 less the distance of its centre from (x, y), within [0, 1].
void Canvas::Dot(double x, double y, double radius_px, const Color& color, double share) {
  for (int j = static_cast<int>(y - radius_px - 1); j <= static_cast<int>(y + radius_px + 1); ++j) {
    for (int i = static_cast<int>(x - radius_px - 1); i <= static_cast<int>(x + radius_px + 1); ++i) {
      const double inside = radius_px + 0.5 - std::hypot(i + 0.5 - x, j + 0.5 - y);
      if (inside > 0.0) Set(i, j, color, share * std::min(inside, 1.0));
    }
  }
}

void Canvas::Circle(double x, double y, double radius_px, const Color& color, double share) {
  const int steps = std::max(12, static_cast<int>(7.0 * radius_px));
  double last_x = -1e9, last_y = -1e9;
  for (int k = 0; k < steps; ++k) {
    const double a = 2.0 * 3.14159265358979 * k / steps;
    const double px = std::floor(x + radius_px * std::cos(a));
    const double py = std::floor(y + radius_px * std::sin(a));
    if (px == last_x && py == last_y) continue;
    Set(static_cast<int>(px), static_cast<int>(py), color, share);
    last_x = px;
    last_y = py;
  }
}

void Canvas::Text(const std::string& text, int x, int y, const Color& color, bool is_title) {
  (is_title ? title_ : small_).Draw(text, x, y, color, image);
}

int Canvas::Width(const std::string& text, bool is_title) const {
  return (is_title ? title_ : small_).Width(text);
}

void Canvas::ScaleBar(int x, int y, double width_px, double pixels_per_m) {
  const double length_m = RoundStep(width_px / 3.0 / pixels_per_m);
  const int length_px = static_cast<int>(std::lround(length_m * pixels_per_m));
  FillBox(x - 1, y - 6, x + length_px + 1, y + 7, kPaper, 0.7);
  FillBox(x, y, x + length_px, y + 3, kInk);
  FillBox(x, y - 4, x + 2, y + 7, kInk);
  FillBox(x + length_px - 2, y - 4, x + length_px, y + 7, kInk);
  Text(Length(length_m), x + length_px + 8, y - 8);
}

void Canvas::ColorBar(int x, int y, int height, const std::function<Color(double)>& color_of, const std::string& low,
                      const std::string& high) {
  constexpr int kWidth_px = 18;
  for (int j = 0; j < height; ++j) {
    FillBox(x, y + j, x + kWidth_px, y + j + 1, color_of(1.0 - (j + 0.5) / height));
  }
  Frame(x, y, x + kWidth_px, y + height, kGrey);
  Text(high, x + kWidth_px + 6, y - 6);
  Text(low, x + kWidth_px + 6, y + height - 12);
}

}  // namespace inspect
