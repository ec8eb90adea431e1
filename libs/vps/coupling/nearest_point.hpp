#pragma once

#include <array>
#include <cstddef>

namespace vps {

// A small motion in the unit in which its energy is 1/2 |y|^2: three translations, then three rotations (ToolMetric).
using Vector6 = std::array<double, 6>;

inline double Dot(const Vector6& a, const Vector6& b) {
  return (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3]) + (a[4] * b[4] + a[5] * b[5]);
}
inline void AddScaled(double factor, const Vector6& a, Vector6* y) {
  for (std::size_t k = 0; k < 6; ++k) (*y)[k] += factor * a[k];
}

constexpr std::size_t kMaxHalfSpaces = 128;

// a_i . y >= b_i
struct HalfSpace {
  Vector6 a{};
  double b = 0.0;
  bool is_left_out = false;
  bool was_active = false;  // in the last cycle: where the search begins
};
struct HalfSpaces {
  std::array<HalfSpace, kMaxHalfSpaces> of;
  std::size_t count = 0;
};

// Of ProjectOntoHalfSpaces: y, and multipliers with y = target + sum of multipliers[i] a_i.
struct NearestPoint {
  Vector6 y{};
  std::array<double, kMaxHalfSpaces> multipliers{};
  double worst_violation = 0.0;  // more than rounding: half-spaces contradict each other, and y is no solution
};

// The point next to `target` in the intersection of half-spaces: min 1/2 |y - target|^2.
// At most six are active, because more of them depend on each other.
void ProjectOntoHalfSpaces(const Vector6& target, const HalfSpaces& half_spaces, NearestPoint* result) noexcept;

}  // namespace vps
