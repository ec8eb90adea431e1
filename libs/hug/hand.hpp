#pragma once

#include "core/pose.hpp"
#include "core/wrench.hpp"

namespace hug {

// The simulated operator's arm and fingers, which pull the gripper towards their target. A firm grip, assumed.
struct HandImpedance {
  double stiffness_N_per_m = 800.0;
  double damping_N_s_per_m = 60.0;
  double stiffness_Nm_per_rad = 25.0;
  double damping_Nm_s_per_rad = 1.2;
  double finger_stiffness_N_per_m = 1500.0;
  double finger_damping_N_s_per_m = 50.0;
};

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

// About Do in W: f = K (p_T - p_D) + B (v_T - v_D), torque the same with the rotation vector between them.
inline core::Wrench HandWrench(const HandImpedance& k, const Hand& hand, const core::Pose& X_WD,
                               const core::Twist& V_WD) {
  const glm::dvec3 turn = core::RotationVector(X_WD.rotation * glm::conjugate(hand.X_WT.rotation));
  return {
      k.stiffness_N_per_m * (hand.X_WT.translation - X_WD.translation) +
          k.damping_N_s_per_m * (hand.V_WT.linear_m_per_s - V_WD.linear_m_per_s),
      -k.stiffness_Nm_per_rad * turn + k.damping_Nm_s_per_rad * (hand.V_WT.angular_rad_per_s - V_WD.angular_rad_per_s)};
}

}  // namespace hug
