#include "physics/snap_profile.hpp"

#include <algorithm>

namespace physics {

double SnapProfile::Slope_per_m(double z) const {
  for (std::size_t i = 0; i + 1 < static_cast<std::size_t>(num_points); ++i) {
    if (z >= z_m[i] && z < z_m[i + 1]) return (share[i + 1] - share[i]) / (z_m[i + 1] - z_m[i]);
  }
  return 0.0;
}

double SnapProfile::Share(double z) const {
  for (std::size_t i = 0; i + 1 < static_cast<std::size_t>(num_points); ++i) {
    if (z >= z_m[i] && z < z_m[i + 1]) return share[i] + Slope_per_m(z) * (z - z_m[i]);
  }
  return 0.0;
}

double SnapProfile::Area_m(double z) const {
  double area_m = 0.0;
  for (std::size_t i = 0; i + 1 < static_cast<std::size_t>(num_points); ++i) {
    if (z >= z_m[i + 1]) continue;
    const double from = std::max(z, z_m[i]);
    const double at_from = from > z_m[i] ? Share(from) : share[i];
    area_m += 0.5 * (at_from + share[i + 1]) * (z_m[i + 1] - from);
  }
  return area_m;
}

}  // namespace physics
