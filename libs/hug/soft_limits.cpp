#include "hug/soft_limits.hpp"

#include <algorithm>
#include <cmath>

namespace hug {

// Beyond the margin by e > 0, moving out at e': tau = -(k e + d max(e', 0)). The damper does not hold an arm that comes
// back.
Joints LimitTorques(const SoftLimits& limits, const ArmDynamics& arm, const Joints& q, const Joints& speed,
                    bool* is_touched) {
  Joints torques{};
  *is_touched = false;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double side = q[i] < 0.0 ? -1.0 : 1.0;
    const double beyond = side * q[i] - (arm.model().limit[i] - limits.joint_margin_rad);
    if (beyond <= 0.0) continue;
    *is_touched = true;
    torques[i] = -side * (limits.joint_stiffness_Nm_per_rad * beyond +
                          limits.joint_damping_Nm_s_per_rad * std::max(side * speed[i], 0.0));
  }
  // Link 1 turns about the shoulder, link 5 about the wrist.
  constexpr std::size_t kShoulder = 1, kWrist = 5;
  const glm::dvec3 r = arm.X_WL(kWrist).translation - arm.X_WL(kShoulder).translation;
  const double distance_m = glm::length(r);
  const double beyond_m = distance_m - limits.stretch_m;
  if (beyond_m > 0.0) {
    *is_touched = true;
    const glm::dvec3 outwards = r / distance_m;
    // Speed along the line from the shoulder: by the principle of virtual work, that of a unit force.
    const Joints unit = arm.TorquesOf(kWrist, arm.X_WL(kWrist).translation, outwards);
    double out_m_per_s = 0.0;
    for (std::size_t i = 0; i < kJoints; ++i) out_m_per_s += unit[i] * speed[i];
    const double pull_N =
        limits.stretch_stiffness_N_per_m * beyond_m + limits.stretch_damping_N_s_per_m * std::max(out_m_per_s, 0.0);
    torques = torques - pull_N * unit;
  }
  return torques;
}

}  // namespace hug
