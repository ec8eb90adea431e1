#include "nodes/visual_node/force_loop.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <string>
#include <string_view>

namespace visual_node {
namespace {

constexpr std::array<std::string_view, 4> kPrograms = {"device_bridge", "haptic_node", "physics_node",
                                                       "haptic_physics_node"};

// Of the command line, which any user may read. Its name in `comm` is that of its first thread, which a node renames.
std::string ProgramOf(const std::filesystem::path& process) {
  std::string program;
  std::getline(std::ifstream(process / "cmdline"), program, '\0');  // not a process: no such file
  return std::filesystem::path(program).filename();
}

}  // namespace

bool HasForceLoop(const std::filesystem::path& processes) {
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(processes, ignored)) {
    if (std::find(kPrograms.begin(), kPrograms.end(), ProgramOf(entry.path())) != kPrograms.end()) return true;
  }
  return false;
}

}  // namespace visual_node
