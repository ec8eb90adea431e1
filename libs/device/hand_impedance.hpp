#pragma once

#include "core/pose.hpp"
#include "core/wrench.hpp"

namespace device {

// The simulated operator's arm and fingers, which pull a simulated device towards their target: a firm grip, assumed. A
// softer hand penetrates less and reacts slower.
struct HandImpedance {
  double stiffness_N_per_m = 800.0;
  double damping_N_s_per_m = 60.0;
  double stiffness_Nm_per_rad = 25.0;
  double damping_Nm_s_per_rad = 1.2;
  double finger_stiffness_N_per_m = 1500.0;
  double finger_damping_N_s_per_m = 50.0;
};

// On the device, about Do in W: f = K (p_T - p_D) + B (v_T - v_D), torque the same with the rotation vector between
// them.
inline core::Wrench HandWrench(const HandImpedance& k, const core::Pose& X_WT, const core::Twist& V_WT,
                               const core::Pose& X_WD, const core::Twist& V_WD) {
  const glm::dvec3 turn = core::RotationVector(X_WD.rotation * glm::conjugate(X_WT.rotation));
  return {k.stiffness_N_per_m * (X_WT.translation - X_WD.translation) +
              k.damping_N_s_per_m * (V_WT.linear_m_per_s - V_WD.linear_m_per_s),
          -k.stiffness_Nm_per_rad * turn + k.damping_Nm_s_per_rad * (V_WT.angular_rad_per_s - V_WD.angular_rad_per_s)};
}

}  // namespace device
