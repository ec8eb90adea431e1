#pragma once

#include <string>
#include <utility>
#include <vector>

#include "device/plugin.h"
#include "scene/scenario.hpp"

namespace device_bridge {

// The simulated arms as devices: type "simulated_arm", a point mass, and "simulated_hug", seven joints.
const oos_device_plugin& SimulatedArmPlugin();
const oos_device_plugin& SimulatedHugPlugin();

// A scenario's figures as options for them. Numbers are written so that they are read back bit by bit.
std::vector<std::pair<std::string, std::string>> ArmOptions(const scene::Device& device);
// And back again.
scene::Device ArmFiguresOf(const oos_device_setting& setting);

}  // namespace device_bridge
