#pragma once

#include <span>

#include "hug/capsules.hpp"

namespace hug {

// Springs and dampers between the bars of two arms, and between them and bodies that stand still.
struct Avoidance {
  double begins_m = 0.06;             // distance between surfaces where it begins to push
  double stiffness_N_per_m = 1500.0;  // 90 N before they touch: more than a hand may push with (40 N)
  double damping_N_s_per_m = 60.0;
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
