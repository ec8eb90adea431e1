#include "nodes/visual_node/force_loop.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <string>

namespace visual_node {
namespace {

// As the kernel has them: 15 letters at most.
constexpr std::array<const char*, 4> kPrograms = {"device_bridge", "haptic_node", "physics_node", "haptic_physics_"};

}  // namespace

bool HasForceLoop(const std::filesystem::path& processes) {
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(processes, ignored)) {
    std::string name;
    std::getline(std::ifstream(entry.path() / "comm"), name);  // not a process: no such file
    if (std::find(kPrograms.begin(), kPrograms.end(), name) != kPrograms.end()) return true;
  }
  return false;
}

}  // namespace visual_node
