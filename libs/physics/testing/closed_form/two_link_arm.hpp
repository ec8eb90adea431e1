#pragma once

#include <array>

namespace physics::closed_form {

// A planar arm of two links that turn about parallel axes, without gravity. Lengths from joint to joint and from joint
// to the link's centre of mass, which lies on the line between the joints; inertias about the centres of mass.
struct TwoLinkArm {
  double length_1_m = 0.0;
  double center_1_m = 0.0;
  double mass_1_kg = 0.0;
  double inertia_1_kg_m2 = 0.0;
  double center_2_m = 0.0;
  double mass_2_kg = 0.0;
  double inertia_2_kg_m2 = 0.0;
};

// Joint accelerations in rad/s^2 at the angles q (the second against the first link), rates w and torques. From
// Lagrange's equations [Spong, Hutchinson and Vidyasagar, Robot Modeling and Control, 2006, section 7.4]:
//   M11 = I1 + I2 + m1 c1^2 + m2 (l1^2 + c2^2 + 2 l1 c2 cos q2),  M12 = I2 + m2 (c2^2 + l1 c2 cos q2),
//   M22 = I2 + m2 c2^2,  h = m2 l1 c2 sin q2
//   M w' = t + h (2 w1 w2 + w2^2, -w1^2)
std::array<double, 2> TwoLinkAccelerations(const TwoLinkArm& arm, const std::array<double, 2>& q_rad,
                                           const std::array<double, 2>& w_rad_per_s,
                                           const std::array<double, 2>& torque_Nm);

}  // namespace physics::closed_form
