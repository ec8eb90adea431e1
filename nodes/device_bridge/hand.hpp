#pragma once

#include "core/pose.hpp"
#include "core/wrench.hpp"

namespace device_bridge {

// Target of the spring-dampers of an operator's simulated arm and fingers: the only output of whoever moves a simulated
// device.
struct HandTarget {
  core::Pose X_WT;
  core::Twist V_WT;  // velocity of the target, so that a moving hand has no lag
  double opening_m = 0.0;
  double opening_velocity_m_per_s = 0.0;
  double grip_strength_N = 20.0;  // largest force of the fingers, opening and closing
  bool holds_dead_man = true;
};

// Forces that the operator feels.
struct FeltForce {
  core::Wrench F_Do_W;          // the arm on the hand
  core::Wrench hand_F_Do_W;     // the hand's own spring and damper on the arm
  double grip_force_N = 0.0;    // the jaws on the fingers, positive when they are pushed open
  double finger_force_N = 0.0;  // the fingers on the jaws, positive opens
  double opening_m = 0.0;
  bool is_off = false;  // the device has withdrawn its force, or is ramping it up again, and indicates this
};

}  // namespace device_bridge
