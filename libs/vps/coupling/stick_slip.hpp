#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "vps/coupling/nearest_point.hpp"

namespace vps {

// A touching place with Coulomb friction, in the unit of y.
struct FrictionContact {
  Vector6 normal{};                   // of its half-space: normal . y >= bound
  std::array<Vector6, 2> tangents{};  // of two orthogonal directions along the plane
  std::array<double, 2> slip_m{};     // from where it sticks, at y = 0
  double bound = 0.0;
  double friction = 0.0;
  double most_N = 0.0;  // of the normal force
  // On entry what it was in the last cycle; the result.
  double normal_N = 0.0;
  std::array<double, 2> tangent_N{};
};

constexpr std::size_t kMaxFrictionContacts = 24;

// Finds y = target + sum of forces, such that of each contact
//   the normal force is only as large as keeps it from entering its half-space, and at most most_N;
//   it either sticks, slip + tangents . y = 0, with a tangential force of at most `friction` times the normal force,
//   or slips against a tangential force of just that size.
// Returns y. Starts from the contacts' forces and improves them; ends after `most_sweeps` at the latest.
Vector6 SolveStickSlip(const Vector6& target, std::span<FrictionContact> contacts, int most_sweeps) noexcept;

}  // namespace vps
