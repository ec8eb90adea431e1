#pragma once

#include <array>
#include <cstddef>

namespace hug {

inline constexpr std::size_t kJoints = 7;
using Joints = std::array<double, kJoints>;  // rad, rad/s, rad/s2 or Nm, base first

inline constexpr Joints operator+(Joints a, const Joints& b) {
  for (std::size_t i = 0; i < kJoints; ++i) a[i] += b[i];
  return a;
}
inline constexpr Joints operator-(Joints a, const Joints& b) {
  for (std::size_t i = 0; i < kJoints; ++i) a[i] -= b[i];
  return a;
}
inline constexpr Joints operator*(double s, Joints a) {
  for (double& value : a) value *= s;
  return a;
}

}  // namespace hug
