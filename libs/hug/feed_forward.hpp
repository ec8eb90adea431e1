#pragma once

#include "core/wrench.hpp"

namespace hug {

// Feed-forward of the force at the wrist lowers the inertia that a hand feels. With the wanted force F, the force F_s
// of the hand on the arm, and a gain k, the motors apply
//   F_m = F + k (F_s + F),   so that   m a = F_m + F_s = (1 + k) (F + F_s):
// the hand feels m / (1 + k) under the force F, as if the arm were that light.
inline core::Wrench FeedForward(const core::Wrench& wanted, const core::Wrench& measured, double gain) {
  return wanted + gain * (measured + wanted);
}

inline constexpr double GainForShare(double share_of_inertia) {
  return 1.0 / share_of_inertia - 1.0;
}

// With a mass m_h held rigidly beyond the sensor and the force late by any time, the measured force obeys
//   (1 + m_h / m) F_s(t) = ... - k (m_h / m) F_s(t - t_d),
// a neutral equation, which is stable if and only if k (m_h / m) < 1 + m_h / m.
inline constexpr double LargestStableGain(double arm_kg, double held_kg) {
  return 1.0 + arm_kg / held_kg;
}

}  // namespace hug
