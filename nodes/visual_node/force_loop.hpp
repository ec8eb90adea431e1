#pragma once

#include <filesystem>

namespace visual_node {

// Whether a node of the force loop (device_bridge, haptic_node, physics_node) runs on this machine, whatever its
// session. `processes`: the kernel's list of them.
bool HasForceLoop(const std::filesystem::path& processes = "/proc");

}  // namespace visual_node
