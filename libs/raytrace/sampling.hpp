#pragma once

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

namespace raytrace {

// Points that fill [0, 1)^2 evenly, whatever their number: the Halton sequence [Halton 1960] in two bases, shifted by
// an amount of its own at each pixel [Cranley and Patterson 1976], so that what is left of errors is noise, not a
// pattern.
class Samples {
 public:
  // `sample`: its number, from 1 on. Different bases for what must not depend on each other.
  Samples(std::uint32_t sample, int x, int y)
      : sample_(sample),
        pixel_(Mix(Mix(static_cast<std::uint32_t>(x)) ^ static_cast<std::uint32_t>(y) * 0x9E3779B9u)) {}

  [[nodiscard]] glm::vec2 Point(std::uint32_t base_x, std::uint32_t base_y) const {
    return glm::fract(glm::vec2(Inverse(sample_, base_x), Inverse(sample_, base_y)) +
                      glm::vec2(Share(Mix(pixel_ + base_x)), Share(Mix(pixel_ + base_y))));
  }

  // The digits of `i` behind the point, in reverse order.
  static float Inverse(std::uint32_t i, std::uint32_t base) {
    float value = 0.0f;
    for (float place = 1.0f / static_cast<float>(base); i > 0; i /= base, place /= static_cast<float>(base)) {
      value += static_cast<float>(i % base) * place;
    }
    return value;
  }

 private:
  static std::uint32_t Mix(std::uint32_t h) {
    h = (h ^ h >> 16) * 0x7FEB352Du;
    h = (h ^ h >> 15) * 0x846CA68Bu;
    return h ^ h >> 16;
  }
  static float Share(std::uint32_t h) { return static_cast<float>(h >> 8) * (1.0f / 16777216.0f); }

  std::uint32_t sample_;
  std::uint32_t pixel_;
};

// Two directions across n, at right angles to each other. `n` is of unit length.
inline void AcrossOf(const glm::vec3& n, glm::vec3* u, glm::vec3* v) {
  *u = glm::normalize(std::abs(n.x) > 0.7f ? glm::vec3(n.y, -n.x, 0.0f) : glm::vec3(0.0f, n.z, -n.y));
  *v = glm::cross(n, *u);
}

// A direction within `radius_rad` (small) around d, evenly spread over that disc.
inline glm::vec3 WithinDisc(const glm::vec3& d, float radius_rad, const glm::vec2& point) {
  glm::vec3 u, v;
  AcrossOf(d, &u, &v);
  const float r = radius_rad * std::sqrt(point.x), angle = 6.2831853f * point.y;
  return glm::normalize(d + r * (std::cos(angle) * u + std::sin(angle) * v));
}

// A direction above a surface, more often near its normal: as often as a matt surface takes light from there.
inline glm::vec3 AboveSurface(const glm::vec3& n, const glm::vec2& point) {
  glm::vec3 u, v;
  AcrossOf(n, &u, &v);
  const float r = std::sqrt(point.x), angle = 6.2831853f * point.y;
  return glm::normalize(r * std::cos(angle) * u + r * std::sin(angle) * v + std::sqrt(1.0f - point.x) * n);
}

}  // namespace raytrace
