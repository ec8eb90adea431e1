#pragma once

#include <array>

namespace physics {

// Force against insertion of a snap over the distance z from the seat, piecewise linear, zero outside. Forces are
// relative to the largest one, so that the profile can be scaled.
struct SnapProfile {
  static constexpr int kMaxPoints = 16;
  int num_points = 0;                      // 0: no profile; else at least 3, the first and the last with force 0
  std::array<double, kMaxPoints> z_m{};    // ascending
  std::array<double, kMaxPoints> share{};  // 0 to 1

  [[nodiscard]] double Share(double z) const;
  [[nodiscard]] double Slope_per_m(double z) const;  // d share / dz
  [[nodiscard]] double Area_m(double z) const;       // integral of the share from z outwards
};

}  // namespace physics
