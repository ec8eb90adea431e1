#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "nodes/lockstep/replay_steps.hpp"
#include "tests/support.hpp"

namespace system_tests {

inline std::filesystem::path GoldenFolder() {
  return std::filesystem::path(VR_OOS_SOURCE_DIR) / "tests" / "golden";
}
// Of the paper's method and coupling.
inline std::filesystem::path GoldenFile() {
  return GoldenFolder() / "module_replacement.mcap";
}
// Of the default: fast, god_object.
inline std::filesystem::path GoldenFileOfTheDefault() {
  return GoldenFolder() / "module_replacement_default.mcap";
}

inline lockstep::RecordedNode GoldenNode(const std::string& name, const std::filesystem::path& file = GoldenFile()) {
  const auto nodes = lockstep::ReadRecordedNodes(file);
  if (!nodes) {
    ADD_FAILURE() << nodes.error().detail;
    return {};
  }
  for (const lockstep::RecordedNode& node : *nodes) {
    if (node.node == name) return node;
  }
  ADD_FAILURE() << "no steps of " << name;
  return {};
}

}  // namespace system_tests
