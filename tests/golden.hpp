#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/support.hpp"
#include "tools/oos/replay_steps.hpp"

namespace system_tests {

inline std::filesystem::path GoldenFolder() {
  return std::filesystem::path(VR_OOS_SOURCE_DIR) / "tests" / "golden";
}
inline std::filesystem::path GoldenFile() {
  return GoldenFolder() / "module_replacement.mcap";
}

inline oos::RecordedNode GoldenNode(const std::string& name) {
  const auto nodes = oos::ReadRecordedNodes(GoldenFile());
  if (!nodes) {
    ADD_FAILURE() << nodes.error().detail;
    return {};
  }
  for (const oos::RecordedNode& node : *nodes) {
    if (node.node == name) return node;
  }
  ADD_FAILURE() << "no steps of " << name;
  return {};
}

}  // namespace system_tests
