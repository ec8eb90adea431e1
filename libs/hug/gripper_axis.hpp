#pragma once

#include <algorithm>
#include <cmath>

#include "hug/hand.hpp"

namespace hug {

// The axis of the gripper: an apparent mass with friction between end stops, moved by its motor and by fingers.
struct GripperAxis {
  double opening_m = 0.06;
  double velocity_m_per_s = 0.0;
  double finger_N = 0.0;  // of the fingers' spring, positive opens

  static constexpr double kMass_kg = 0.5;         // with the fingers; assumed
  static constexpr double kDrag_N_s_per_m = 2.0;  // assumed

  // Semi-implicit in the dampers, so that any brake is stable. The fingers' spring pulls with no more than their
  // strength.
  void Step(double dt_s, const HandImpedance& k, const Hand& hand, bool is_held, double motor_N, double brake_N_s_per_m,
            double opening_max_m) {
    finger_N = 0.0;
    double drag = kDrag_N_s_per_m + brake_N_s_per_m;
    double force_N = motor_N;
    if (is_held) {
      finger_N = std::clamp(k.finger_stiffness_N_per_m * (hand.opening_m - opening_m), -hand.grip_strength_N,
                            hand.grip_strength_N);
      drag += k.finger_damping_N_s_per_m;
      force_N += finger_N + k.finger_damping_N_s_per_m * hand.opening_velocity_m_per_s;
    }
    velocity_m_per_s = (velocity_m_per_s + dt_s * force_N / kMass_kg) / (1.0 + dt_s * drag / kMass_kg);
    const double next_m = opening_m + dt_s * velocity_m_per_s;
    opening_m = std::clamp(next_m, 0.0, opening_max_m);
    if (opening_m != next_m) velocity_m_per_s = 0.0;
  }
};

}  // namespace hug
