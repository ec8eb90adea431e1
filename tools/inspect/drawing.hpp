#pragma once

#include <array>
#include <functional>
#include <glm/glm.hpp>
#include <string>

#include "core/result.hpp"
#include "picture/glyph_atlas.hpp"
#include "picture/image.hpp"
#include "vps/mesh/triangle_mesh.hpp"

namespace inspect {

using Color = std::array<std::uint8_t, 3>;

constexpr Color kInk{32, 34, 38};
constexpr Color kGrey{120, 124, 130};
constexpr Color kPaper{250, 250, 248};

// (1 - share) a + share b, share clamped to [0, 1].
Color Mix(const Color& a, const Color& b, double share);

// Perceptually uniform colour map (viridis at five stops), dark violet over green to yellow, t clamped to [0, 1].
Color Ramp(double t);

// The largest of 1, 2, 5 times a power of ten that is not above x.
double RoundStep(double x);

// "25 mm", "0.4 mm", "1.2 m".
std::string Length(double length_m);

// An orthographic view of the mesh frame: pixel = (x, y) + pixels_per_m (right . r, -up . r), r = p - centre_m.
struct View {
  glm::dvec3 right{1, 0, 0}, up{0, 1, 0}, toward{0, 0, 1};  // `toward` the viewer
  glm::dvec3 centre_m{0.0};
  double pixels_per_m = 1.0;
  double x = 0.0, y = 0.0;  // pixel of centre_m

  [[nodiscard]] glm::dvec2 Pixel(const glm::dvec3& p_m) const {
    const glm::dvec3 r = p_m - centre_m;
    return {x + pixels_per_m * glm::dot(right, r), y - pixels_per_m * glm::dot(up, r)};
  }
  [[nodiscard]] glm::dvec3 Point(double px, double py) const {
    return centre_m + ((px - x) * right - (py - y) * up) / pixels_per_m;
  }
};

// The view from: 0 +x (y right, z up), 1 -y (x right, z up), 2 +z (x right, y up), 3 above, at a slant.
View MakeView(int direction);

// Sets centre and scale so that the box fills the square of `side_px` pixels around (x, y).
void Fit(const vps::Box& box, double x, double y, double side_px, View* view);

// A picture with text.
class Canvas {
 public:
  // Errors: those of GlyphAtlas::Create (no font).
  static core::Result<Canvas> Create(int width, int height);

  picture::Image image;

  void Set(int x, int y, const Color& color, double share = 1.0);
  void FillBox(int x0, int y0, int x1, int y1, const Color& color, double share = 1.0);
  void Frame(int x0, int y0, int x1, int y1, const Color& color);
  void Dot(double x, double y, double radius_px, const Color& color, double share = 1.0);
  void Circle(double x, double y, double radius_px, const Color& color, double share = 1.0);
  void Text(const std::string& text, int x, int y, const Color& color = kInk, bool is_title = false);
  [[nodiscard]] int Width(const std::string& text, bool is_title = false) const;
  // A bar of a round length, at most a third of `width_px`, its left end at (x, y).
  void ScaleBar(int x, int y, double width_px, double pixels_per_m);
  // Vertical, from bottom to top, with its ends named.
  void ColorBar(int x, int y, int height, const std::function<Color(double)>& color_of, const std::string& low,
                const std::string& high);

 private:
  Canvas(picture::GlyphAtlas small, picture::GlyphAtlas title) : small_(std::move(small)), title_(std::move(title)) {}

  picture::GlyphAtlas small_, title_;
};

}  // namespace inspect
