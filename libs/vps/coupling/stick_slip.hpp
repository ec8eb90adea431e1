#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <span>

#include "vps/coupling/nearest_point.hpp"

namespace vps {

// Of every contact, along its normal and along its plane [N/m]: 0.1 um at 10 N. As good as rigid beside a hand's spring
// of 1e3 N/m, and well within what double precision solves.
constexpr double kContactStiffness_N_per_m = 1e8;

// A contact with Coulomb friction, in the unit of y.
struct Contact {
  // Of its half-space: normal . y >= bound.
  Vector6 normal{};
  double bound = 0.0;
  double most_N = std::numeric_limits<double>::infinity();  // of the normal force
  // Of two orthogonal directions along the plane.
  std::array<Vector6, 2> tangents{};
  std::array<double, 2> slip_m{};  // from where it sticks, at y = 0
  double friction = 0.0;           // 0: `tangents` are not read
  // Of the force along the plane: on entry the last cycle's; the result.
  double limit_N = 0.0;
  // The result.
  double normal_N = 0.0;
  std::array<double, 2> tangent_N{};
  // Of SolveStickSlip only.
  double rise_m = 0.0;
};

// Finds y = target + sum of forces, such that of each contact
//   the normal force is only as large as keeps it from entering its half-space, and at most most_N;
//   it either sticks, slip + tangents . y = 0, with a force along the plane of at most limit_N, or slips against one of
//   just that size;
// where "enters" and "slips" begin after what kContactStiffness_N_per_m gives way, and limit_N is the friction times
// the normal force, about (stick_slip.cpp).
// From `start` to y the forces do no work, but for what slips before have put in: it is a descent from there.
Vector6 SolveStickSlip(const Vector6& target, const Vector6& start, std::span<Contact> contacts) noexcept;

// The same with the limits as they are.
Vector6 SolveStickSlipWithLimits(const Vector6& target, const Vector6& start, std::span<Contact> contacts) noexcept;

}  // namespace vps
