#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace logic_node {

// A parameter change that its owner has accepted.
struct AppliedChange {
  std::string owner;
  std::string name;
  double value = 0.0;
};

// State from which a restarted logic_node continues the run.
struct Checkpoint {
  std::vector<std::uint8_t> state;  // LogicNode::Save
  std::vector<AppliedChange> applied;
};

// Replaces the file atomically: a process killed while writing leaves the previous one. Error: kIo.
core::Result<void> WriteCheckpoint(const Checkpoint& checkpoint, const std::filesystem::path& file);
// Errors: kNotFound, kIo, kDamaged.
core::Result<Checkpoint> ReadCheckpoint(const std::filesystem::path& file);

}  // namespace logic_node
