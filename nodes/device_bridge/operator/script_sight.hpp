#pragma once

#include "nodes/device_bridge/operator/operator_script.hpp"
#include "nodes/device_bridge/operator/perception.hpp"

namespace device_bridge {

// What a line of the script means in a scene that somebody sees.

// An angle counts in comparisons with a tolerance as the length that it is at this lever.
inline constexpr double kLever_m = 0.05;

// Motion of a hand to its goal.
struct Aim {
  bool is_valid = false;    // both frames are seen
  glm::dvec3 way_W{0.0};    // displacement of the hand from its seen pose to the goal [m]
  glm::dvec3 turn_W{0.0};   // rotation vector of the same motion [rad]
  double distance_m = 0.0;  // of the moved frame to its goal
  double angle_rad = 0.0;
  core::Pose X_WHand;  // seen pose
};

// Of reach and carry.
Aim ComputeAim(const OperatorLine& line, const Sighting& seen) noexcept;
bool IsSatisfied(const Condition& condition, const Sighting& seen, int role) noexcept;
// Index of the step that logic_node shows; -1: none of the script's.
int StepIndexOf(const OperatorScript& script, const core::LogicStatus* logic) noexcept;

}  // namespace device_bridge
