#pragma once

#include <array>

namespace physics {

// Force against pushing a snap in, over z, the distance of the seat, as points joined by straight lines; nothing
// outside. Forces are parts of the largest, so that it can be scaled.
struct SnapProfile {
  static constexpr int kMaxPoints = 16;
  int num_points = 0;                      // 0: none given; else at least 3, the first and the last without force
  std::array<double, kMaxPoints> z_m{};    // ascending
  std::array<double, kMaxPoints> share{};  // 0 to 1

  [[nodiscard]] double Share(double z) const;
  [[nodiscard]] double Slope_per_m(double z) const;  // d share / dz
  [[nodiscard]] double Area_m(double z) const;       // integral of the share from z outwards
};

}  // namespace physics
