#include "nodes/visual_node/sky/disc_rectangle.hpp"

#include <algorithm>
#include <cmath>

namespace visual_node {
namespace {

constexpr double kQuarter_rad = 1.5707963267948966;

// From where to where, in [-1, 1] of the picture, the ball reaches across one axis. Seen along the other axis, the ball
// is a circle at the angle `middle` from the view, and its edges are the tangents from the eye. `axis`: where the view
// is in the picture. None: from > to.
glm::dvec2 Reach(double across, double ahead, double sine, double scale, double axis) {
  const double distance = std::sqrt(across * across + ahead * ahead);
  if (distance <= sine) return {-1.0, 1.0};
  const double middle = std::atan2(across, ahead), half = std::asin(sine / distance);
  const double from = middle - half, to = middle + half;
  if (from >= kQuarter_rad || to <= -kQuarter_rad) return {1.0, -1.0};
  return {from <= -kQuarter_rad ? -1.0 : std::clamp(scale * std::tan(from) + axis, -1.0, 1.0),
          to >= kQuarter_rad ? 1.0 : std::clamp(scale * std::tan(to) + axis, -1.0, 1.0)};
}

}  // namespace

glm::ivec4 DiscRectangle(const glm::mat4& clip_sky, const glm::vec3& to_centre, float sine, int width, int height) {
  const auto row = [&](int i) { return glm::dvec3(clip_sky[0][i], clip_sky[1][i], clip_sky[2][i]); };
  const glm::dvec3 e(to_centre);
  const glm::dvec3 view = row(3);
  const double ahead = glm::dot(view, e) / glm::length(view);
  const auto reach = [&](const glm::dvec3& edge) {
    const double axis = glm::dot(edge, view) / glm::dot(view, view);
    const glm::dvec3 side = edge - axis * view;
    return Reach(glm::dot(side, e) / glm::length(side), ahead, sine, glm::length(side), axis);
  };
  const glm::dvec2 x = reach(row(0)), y = reach(row(1));
  if (x[0] > x[1] || y[0] > y[1]) return {0, 0, 0, 0};
  const auto low = [](double at, int size) { return static_cast<int>(std::floor((0.5 + 0.5 * at) * size)); };
  const auto high = [](double at, int size) { return static_cast<int>(std::ceil((0.5 + 0.5 * at) * size)); };
  const glm::ivec2 from(low(x[0], width), low(y[0], height)), to(high(x[1], width), high(y[1], height));
  return {from, to - from};
}

}  // namespace visual_node
