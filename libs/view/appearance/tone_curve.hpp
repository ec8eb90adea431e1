#pragma once

#include <glm/glm.hpp>

namespace view {

// From light to the screen. A tone curve maps unbounded light to [0, 1]; this one is the Khronos PBR Neutral Tone
// Mapper [Khronos Group 2024, github.com/KhronosGroup/ToneMapping]. It leaves hues, and colours up to 0.76, as the
// material states them, so that gold stays gold in the sun, and takes off the 4 % of light that a dielectric mirrors:
//   x = min(r, g, b),  p = max(r, g, b) - offset,  offset = x - 6.25 x^2 for x < 0.08, else 0.04,
//   p' = 1 - d^2 / (p + d - s) for p > s = 0.76, d = 1 - s;  towards white by 1 - 1 / (0.15 (p - p') + 1).
inline glm::vec3 ToneCurve(glm::vec3 light) {
  constexpr float kStart = 0.76f;
  constexpr float kWhitening = 0.15f;
  const float least = glm::min(light.r, glm::min(light.g, light.b));
  light -= least < 0.08f ? least - 6.25f * least * least : 0.04f;
  const float peak = glm::max(light.r, glm::max(light.g, light.b));
  if (peak < kStart) return light;
  const float d = 1.0f - kStart;
  const float new_peak = 1.0f - d * d / (peak + d - kStart);
  const float white = 1.0f - 1.0f / (kWhitening * (peak - new_peak) + 1.0f);
  return glm::mix(light * (new_peak / peak), glm::vec3(new_peak), white);
}

// The transfer function of sRGB [IEC 61966-2-1], piecewise as in the standard.
inline glm::vec3 EncodeSrgb(const glm::vec3& linear) {
  return glm::mix(12.92f * linear, 1.055f * glm::pow(linear, glm::vec3(1.0f / 2.4f)) - 0.055f,
                  glm::greaterThan(linear, glm::vec3(0.0031308f)));
}

inline glm::vec3 DecodeSrgb(const glm::vec3& encoded) {
  return glm::mix(encoded / 12.92f, glm::pow((encoded + 0.055f) / 1.055f, glm::vec3(2.4f)),
                  glm::greaterThan(encoded, glm::vec3(0.04045f)));
}

}  // namespace view
