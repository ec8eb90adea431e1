#include "hug/soft_limits.hpp"

#include <algorithm>
#include <cmath>

namespace hug {

namespace {

// Speed from which something of which `left` is left to its limit can be stopped there with the deceleration a:
//   v = sqrt(2 a left),   and near the limit v = left / tau, where the root has no slope. Beyond it, none.
double SpeedThatStops(double left, double deceleration, double tau_s) {
  if (left <= 0.0) return 0.0;
  return left < 2.0 * deceleration * tau_s * tau_s ? left / tau_s : std::sqrt(2.0 * deceleration * left);
}

// Of a spring K beyond the limit and a damper B of what is too fast for what is left. With tau = B / K the damper's
// slope before the limit is the spring's beyond it. The damper does not hold what comes back.
double Push(double left, double outwards, double stiffness, double damping, double deceleration) {
  const double excess = outwards - SpeedThatStops(left, deceleration, damping / stiffness);
  return stiffness * std::max(-left, 0.0) + damping * std::max(std::min(excess, outwards), 0.0);
}

}  // namespace

Joints LimitTorques(const SoftLimits& limits, const ArmDynamics& arm, const Joints& q, const Joints& speed,
                    bool* is_touched) {
  Joints torques{};
  *is_touched = false;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double side = q[i] < 0.0 ? -1.0 : 1.0;
    const double left = arm.model().limit[i] - limits.joint_margin_rad - side * q[i];
    const double push_Nm = Push(left, side * speed[i], limits.joint_stiffness_Nm_per_rad,
                                limits.joint_damping_Nm_s_per_rad, limits.joint_deceleration_rad_per_s2);
    *is_touched = *is_touched || push_Nm > 0.0;
    torques[i] = -side * push_Nm;
  }
  // Link 1 turns about the shoulder, link 5 about the wrist.
  constexpr std::size_t kShoulder = 1, kWrist = 5;
  const glm::dvec3 r = arm.X_WL(kWrist).translation - arm.X_WL(kShoulder).translation;
  const double distance_m = glm::length(r);
  // Speed along the line from the shoulder: by the principle of virtual work, that of a unit force.
  const Joints unit = arm.TorquesOf(kWrist, arm.X_WL(kWrist).translation, r / distance_m);
  double out_m_per_s = 0.0;
  for (std::size_t i = 0; i < kJoints; ++i) out_m_per_s += unit[i] * speed[i];
  const double pull_N = Push(limits.stretch_m - distance_m, out_m_per_s, limits.stretch_stiffness_N_per_m,
                             limits.stretch_damping_N_s_per_m, limits.stretch_deceleration_m_per_s2);
  *is_touched = *is_touched || pull_N > 0.0;
  return torques - pull_N * unit;
}

}  // namespace hug
