#pragma once

#include <array>

#include "stability/sampled_axis.hpp"

namespace stability {

using Matrix6 = std::array<std::array<double, 6>, 6>;

// Shape s of a free vibration of M x'' + K x = 0, with s^T M s = 1, and its stiffness s^T K s (the squared angular
// frequency). In its direction a device of several degrees of freedom is one of unit mass.
struct Mode {
  double stiffness_per_s2 = 0.0;
  std::array<double, 6> shape{};
};

// The modes of M^-1 K: M symmetric and positive definite, K symmetric. Real-time: no allocation.
std::array<Mode, 6> Modes(const Matrix6& M, const Matrix6& K) noexcept;

// A hand device of six degrees of freedom, about one point and in one frame: translation [kg, N s/m], then rotation
// [kg m^2, Nm s/rad].
struct SampledBody {
  Matrix6 M{};
  Matrix6 b{};
  double period_s = 1e-3;
  double delay_s = 0.0;
};

// Whether every mode of the body on a wall with stiffness K and damping B is stable. Exact where b and B are diagonal
// in the modes of M^-1 K, as they are when both are multiples of M or K; otherwise it leaves out that modes exchange
// energy.
bool IsStable(const SampledBody& body, const Matrix6& K, const Matrix6& B) noexcept;

// Largest s for which s K with B is stable: the smallest over the modes.
double LargestStableShare(const SampledBody& body, const Matrix6& K, const Matrix6& B) noexcept;

}  // namespace stability
