#pragma once

#include "core/pose.hpp"
#include "core/wrench.hpp"
#include "device/hand_impedance.hpp"

namespace hug {

using device::HandImpedance;

struct Hand {
  core::Pose X_WT;
  core::Twist V_WT;
  double opening_m = 0.0;
  double opening_velocity_m_per_s = 0.0;
  double grip_strength_N = 20.0;
  bool holds_dead_man = false;

  // The target goes on with its velocity.
  void Move(double dt_s) {
    X_WT.translation += dt_s * V_WT.linear_m_per_s;
    X_WT.rotation = glm::normalize(core::QuaternionFromRotationVector(dt_s * V_WT.angular_rad_per_s) * X_WT.rotation);
    opening_m += dt_s * opening_velocity_m_per_s;
  }
};

inline core::Wrench HandWrench(const HandImpedance& k, const Hand& hand, const core::Pose& X_WD,
                               const core::Twist& V_WD) {
  return device::HandWrench(k, hand.X_WT, hand.V_WT, X_WD, V_WD);
}

}  // namespace hug
