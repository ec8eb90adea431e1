#pragma once

#include <span>

#include "core/messages/device.hpp"
#include "core/wrench.hpp"
#include "vps/coupling/god_object.hpp"

namespace haptic_node {

// Adds to a command how its force changes with the device: the tool's contacts after a step of `god_object`, of which
// the command's force is made (device_bridge/contact_field.hpp). Those that carry come first, then the nearest; more
// than the field holds are left out. `X_WO` and `V_WO` are the poses and velocities of all objects. The command is to
// have its wrench, and in F_rest_Do_W, force_cap_N and gain how that was made.
void WriteContactField(const vps::GodObject& god_object, const core::Pose& X_WD, std::span<const core::Pose> X_WO,
                       std::span<const core::Twist> V_WO, core::DeviceCommand* command) noexcept;

}  // namespace haptic_node
