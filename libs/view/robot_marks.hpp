#pragma once

#include "core/messages/device.hpp"
#include "view/scene.hpp"

namespace view {

// A device that is a robot, as the paper's robot viewer shows it (Fig. 12): its links as bars of beads; at each joint
// an arc for the torque that is measured less the one that is commanded, and a billboard with the joint's figures; a
// green phantom where the motion interpolator wants the robot. Of these primitives alone, so every renderer draws it.
void AddRobot(const core::DeviceJoints& robot, Scene* scene);

// Name of DeviceJoints::state, and of its first_cause.
const char* RobotStateName(std::uint8_t state);
const char* RobotCauseName(std::uint8_t cause);

// An arc of half a turn is this torque. Below the least one nothing is drawn: sensors are no better.
inline constexpr double kHalfTurn_Nm = 20.0;
inline constexpr double kLeastArc_Nm = 0.5;

}  // namespace view
