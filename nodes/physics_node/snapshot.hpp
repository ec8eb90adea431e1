#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/result.hpp"
#include "physics/checkpoint.hpp"

namespace physics_node {

// The complete state of a physics_node at the end of a tick, from which it continues bit for bit.
struct Snapshot {
  std::uint64_t tick = 0;
  physics::Checkpoint node;    // hands, contacts, grasps
  physics::Checkpoint world;   // bodies, planes, mechanisms, warm starts
  physics::Checkpoint inputs;  // newest contact sets from the bus; empty without a bus
};

// A checkpoint file. `content`: PhysicsNode::content_digest(). Errors: as physics/checkpoint_file.hpp.
core::Result<void> WriteSnapshot(const std::filesystem::path& file, std::uint64_t content, const Snapshot& snapshot);
core::Result<void> ReadSnapshot(const std::filesystem::path& file, std::uint64_t content, Snapshot* snapshot);

// The same as bytes, for a recording. Both use a temporary file.
core::Result<std::vector<std::uint8_t>> EncodeSnapshot(std::uint64_t content, const Snapshot& snapshot);
core::Result<void> DecodeSnapshot(const std::vector<std::uint8_t>& bytes, std::uint64_t content, Snapshot* snapshot);

}  // namespace physics_node
