#include "physics/testing/closed_form/contact_laws.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace physics::closed_form {

double SlopeAcceleration_m_per_s2(double angle_rad, double friction, double gravity_m_per_s2) {
  return std::max(0.0, gravity_m_per_s2 * (std::sin(angle_rad) - friction * std::cos(angle_rad)));
}

double DelayedReboundRatio(double stiffness_N_per_m, double mass_kg, double delay_s) {
  return std::exp(0.5 * std::numbers::pi * std::sqrt(stiffness_N_per_m / mass_kg) * delay_s);
}

double JammingMoment_Nm(double depth_m, double half_width_m, double friction, double F_x_N, double F_z_N) {
  // About to slide both friction forces are mu N, against the motion. Forces: N_mouth - N_tip = F_x and
  // mu (N_mouth + N_tip) = F_z; moments about the tip's centre: M = l N_mouth + r mu (N_mouth - N_tip).
  const double N_mouth = 0.5 * (F_z_N / friction + F_x_N);
  return depth_m * N_mouth + half_width_m * friction * F_x_N;
}

bool CanWedge(double depth_m, double half_width_m, double friction) {
  return depth_m <= 2.0 * half_width_m * friction;
}

}  // namespace physics::closed_form
