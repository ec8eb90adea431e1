#include "physics/testing/closed_form/two_link_arm.hpp"

#include <cmath>

namespace physics::closed_form {

std::array<double, 2> TwoLinkAccelerations(const TwoLinkArm& arm, const std::array<double, 2>& q_rad,
                                           const std::array<double, 2>& w_rad_per_s,
                                           const std::array<double, 2>& torque_Nm) {
  const double along = arm.mass_2_kg * arm.length_1_m * arm.center_2_m * std::cos(q_rad[1]);
  const double h = arm.mass_2_kg * arm.length_1_m * arm.center_2_m * std::sin(q_rad[1]);
  const double M22 = arm.inertia_2_kg_m2 + arm.mass_2_kg * arm.center_2_m * arm.center_2_m;
  const double M12 = M22 + along;
  const double M11 = arm.inertia_1_kg_m2 + arm.mass_1_kg * arm.center_1_m * arm.center_1_m +
                     arm.mass_2_kg * arm.length_1_m * arm.length_1_m + M22 + 2.0 * along;
  const double w1 = w_rad_per_s[0];
  const double w2 = w_rad_per_s[1];
  const double t1 = torque_Nm[0] + h * (2.0 * w1 * w2 + w2 * w2);
  const double t2 = torque_Nm[1] - h * w1 * w1;
  const double determinant = M11 * M22 - M12 * M12;
  return {(M22 * t1 - M12 * t2) / determinant, (M11 * t2 - M12 * t1) / determinant};
}

}  // namespace physics::closed_form
