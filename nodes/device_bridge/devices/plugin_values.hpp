#pragma once

#include <cmath>

#include "core/fixed_vector.hpp"
#include "core/messages/values.hpp"
#include "core/pose.hpp"
#include "core/wrench.hpp"
#include "device/plugin.h"

namespace device_bridge {

// Between the arrays of device/plugin.h and the types of this project.

inline core::Pose PoseOf(const double (&x)[7]) {
  return {{x[0], x[1], x[2], x[3]}, {x[4], x[5], x[6]}};
}
inline void ToArray(const core::Pose& X, double (&x)[7]) {
  x[0] = X.rotation.w;
  x[1] = X.rotation.x;
  x[2] = X.rotation.y;
  x[3] = X.rotation.z;
  for (int i = 0; i < 3; ++i) x[4 + i] = X.translation[i];
}

inline core::Twist TwistOf(const double (&v)[6]) {
  core::Twist twist;
  twist.angular_rad_per_s = {v[0], v[1], v[2]};
  twist.linear_m_per_s = {v[3], v[4], v[5]};
  return twist;
}
inline void ToArray(const core::Twist& V, double (&v)[6]) {
  for (int i = 0; i < 3; ++i) {
    v[i] = V.angular_rad_per_s[i];
    v[3 + i] = V.linear_m_per_s[i];
  }
}

// Of an array that begins with force and torque.
inline core::Wrench WrenchOf(const double* f) {
  return {{f[0], f[1], f[2]}, {f[3], f[4], f[5]}};
}
inline void ToArray(const core::Wrench& F, double* f) {
  for (int i = 0; i < 3; ++i) {
    f[i] = F.force_N[i];
    f[3 + i] = F.torque_Nm[i];
  }
}

// What a device with motors for these axes (OOS_DEVICE_...) makes of a wrench.
inline core::Wrench OfMotors(std::uint32_t actuated, const core::Wrench& F) {
  constexpr glm::dvec3 kNone(0.0);
  return {(actuated & OOS_DEVICE_TRANSLATION) != 0 ? F.force_N : kNone,
          (actuated & OOS_DEVICE_ROTATION) != 0 ? F.torque_Nm : kNone};
}

template <std::size_t N>
bool AreFinite(const double (&values)[N]) {
  for (const double value : values) {
    if (!std::isfinite(value)) return false;
  }
  return true;
}

// Finite, and the quaternion is a unit but for rounding.
inline bool IsPose(const double (&X)[7]) {
  double square = 0.0;
  for (int i = 0; i < 4; ++i) square += X[i] * X[i];
  return std::abs(square - 1.0) < 1e-3 && AreFinite(X);
}

// Into what a device is told. False, and the goal is not usable: it comes of poses that were on the bus.
inline bool FillGoal(const core::Pose& X_BG, double max_force_N, double max_torque_Nm, oos_device_goal* goal) {
  *goal = {};
  goal->size = sizeof *goal;
  ToArray(X_BG, goal->X_BG);
  goal->max_force_N = max_force_N;
  goal->max_torque_Nm = max_torque_Nm;
  return IsPose(goal->X_BG);
}

// Every number that the bridge uses is finite, and poses are poses.
inline bool IsUsable(const oos_device_state& state) {
  return IsPose(state.X_BD) && AreFinite(state.V_BD) && AreFinite(state.applied) && AreFinite(state.hand_F_Do_B) &&
         std::isfinite(state.opening_m) && std::isfinite(state.opening_velocity_m_per_s) &&
         std::isfinite(state.finger_force_N) && AreFinite(state.finger_rad) &&
         (state.num_finger_joints == 0 || state.num_finger_joints == OOS_DEVICE_FINGER_JOINTS);
}
static_assert(OOS_DEVICE_FINGER_JOINTS == core::kMaxFingerJoints);
inline core::FixedVector<double, core::kMaxFingerJoints> FingersOf(const oos_device_state& state) {
  core::FixedVector<double, core::kMaxFingerJoints> finger_rad;
  for (std::uint32_t i = 0; i < state.num_finger_joints; ++i) finger_rad.push_back(state.finger_rad[i]);
  return finger_rad;
}
inline bool IsUsable(const oos_device_joints& joints) {
  if (joints.num_joints > OOS_DEVICE_MAX_JOINTS) return false;
  const bool has_target = joints.has_target != 0;
  if (has_target && !IsPose(joints.X_BD_target)) return false;
  for (std::uint32_t i = 0; i < joints.num_joints; ++i) {
    const oos_device_joint& joint = joints.joints[i];
    if (!IsPose(joint.X_BL) || (has_target && !IsPose(joint.X_BL_target))) return false;
    for (const double value : {joint.position_rad, joint.speed_rad_per_s, joint.measured_Nm, joint.commanded_Nm,
                               joint.temperature_degC, joint.radius_m}) {
      if (!std::isfinite(value)) return false;
    }
  }
  return true;
}

}  // namespace device_bridge
