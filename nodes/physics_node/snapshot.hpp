#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/result.hpp"
#include "physics/checkpoint.hpp"

namespace physics_node {

// All that a physics_node needs to go on bit for bit from the end of a tick.
struct Snapshot {
  std::uint64_t tick = 0;
  physics::Checkpoint node;    // hands, contacts, grasps
  physics::Checkpoint world;   // bodies, planes, mechanisms, warm starts
  physics::Checkpoint inputs;  // newest contact sets, as they came over the bus; empty where there is no bus
};

// `content`: PhysicsNode::content_digest().
core::Result<void> WriteSnapshot(const std::filesystem::path& file, std::uint64_t content, const Snapshot& snapshot);
core::Result<void> ReadSnapshot(const std::filesystem::path& file, std::uint64_t content, Snapshot* snapshot);

// The same as bytes, to be carried in a recording. Both go through a file in the system's folder for such.
core::Result<std::vector<std::uint8_t>> EncodeSnapshot(std::uint64_t content, const Snapshot& snapshot);
core::Result<void> DecodeSnapshot(const std::vector<std::uint8_t>& bytes, std::uint64_t content, Snapshot* snapshot);

}  // namespace physics_node
