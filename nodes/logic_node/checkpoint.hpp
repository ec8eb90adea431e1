#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace logic_node {

// A parameter change that its owner has taken.
struct AppliedChange {
  std::string owner;
  std::string name;
  double value = 0.0;
};

// What a logic_node needs to go on where an earlier life of it ended.
struct Checkpoint {
  std::vector<std::uint8_t> state;  // LogicNode::Save
  std::vector<AppliedChange> applied;
};

// Replaces the file in one piece: who is killed while writing leaves the one before.
core::Result<void> WriteCheckpoint(const Checkpoint& checkpoint, const std::filesystem::path& file);
core::Result<Checkpoint> ReadCheckpoint(const std::filesystem::path& file);

}  // namespace logic_node
