#pragma once

#include <span>

#include "hug/capsules.hpp"

namespace hug {

// Springs and dampers between the bars of two arms, and between them and bodies that stand still.
struct Avoidance {
  // Distance between surfaces where it begins to push: with 0.02 hands of 40 N drive the arms nearer than 5 mm
  // (Avoidance.ArmsThatHandsDriveTogetherDoNotTouch); more takes room from both.
  double begins_m = 0.06;
  double stiffness_N_per_m = 1500.0;  // 90 N before they touch: more than a hand may push with (40 N)
  double damping_N_s_per_m = 60.0;    // half of what is critical for 2.4 kg; a free choice, from 0 to 300 tests pass
};

struct AvoidanceResult {
  Joints first{}, second{};  // torques
  double least_m = 1e9;      // distance between surfaces
};

AvoidanceResult AvoidEachOther(const Avoidance& avoidance, const ArmDynamics& first, const Joints& first_speed,
                               const ArmDynamics& second, const Joints& second_speed);
AvoidanceResult AvoidBodies(const Avoidance& avoidance, const ArmDynamics& arm, const Joints& speed,
                            std::span<const Capsule> bodies);

}  // namespace hug
