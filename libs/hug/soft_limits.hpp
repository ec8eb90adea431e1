#pragma once

#include "hug/arm_dynamics.hpp"

namespace hug {

// Springs and dampers that keep an arm away from its end stops and from being stretched out. They begin a margin before
// the limit, so that at the limit they hold what a firm hand pushes with; and before the margin they slow down what
// could no longer be stopped there with a deceleration that the motors can give. Without that, a virtual body of 1.5 kg
// that meets the springs at 0.4 m/s flies back faster than the arm can follow, and the arm swings up. The margin of 5
// degrees is a free choice: smaller needs stiffer springs, larger takes reach. So are the decelerations: a tenth of
// them slows what HugArm.* moves, three times fail SoftLimits.*; a quarter passes. Of the others a quarter of the
// damping fails there, and with 5 or 100 kN/m or a joints' stiffness of 200; four times the damping passes.
struct SoftLimits {
  double joint_margin_rad = 0.09;             // 5 degrees
  double joint_stiffness_Nm_per_rad = 700.0;  // 63 Nm at the limit: 60 N at 1 m
  double joint_damping_Nm_s_per_rad = 16.0;
  double joint_deceleration_rad_per_s2 = 20.0;
  double stretch_m = 0.77;                     // largest distance from shoulder to wrist; 0.79 m is a straight arm
  double stretch_stiffness_N_per_m = 30000.0;  // 600 N where the arm is straight: more than any hand
  double stretch_damping_N_s_per_m = 350.0;
  double stretch_deceleration_m_per_s2 = 8.0;
};

// Torques of these springs at the posture of `arm`. `is_touched`: whether any acts.
Joints LimitTorques(const SoftLimits& limits, const ArmDynamics& arm, const Joints& q, const Joints& speed,
                    bool* is_touched);

}  // namespace hug
