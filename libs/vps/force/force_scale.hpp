#pragma once

#include <cmath>
#include <cstddef>

namespace vps {

// lambda of [VR-OOS, Eq. 2]: scales the penetration sum of n colliding points out of N so that contacts of few points
// count more. Continuous at n = rho N, where it is 1/(rho N); n lambda(n) grows to exactly 1 there.
// In the paper's formula e is Euler's number, not the voxel offset e_i of Eq. 1. Zero when nothing collides.
inline double ForceScale(std::size_t num_colliding, std::size_t num_points, double rho = 0.01, double alpha = 2.0) {
  if (num_colliding == 0) return 0.0;
  constexpr double kEuler = 2.718281828459045;
  const double n = static_cast<double>(num_colliding);
  const double rho_N = rho * static_cast<double>(num_points);
  if (n >= rho_N) return 1.0 / n;
  return std::pow(std::log(rho_N + kEuler) / std::log(n + kEuler), alpha) / rho_N;
}

}  // namespace vps
