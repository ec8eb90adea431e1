#include "nodes/physics_node/snapshot.hpp"

#include "physics/checkpoint_file.hpp"

namespace physics_node {

core::Result<void> WriteSnapshot(const std::filesystem::path& file, std::uint64_t content, const Snapshot& snapshot) {
  const physics::Checkpoint* const parts[] = {&snapshot.node, &snapshot.world, &snapshot.inputs};
  return physics::WriteCheckpointFile(file, content, snapshot.tick, parts);
}

core::Result<void> ReadSnapshot(const std::filesystem::path& file, std::uint64_t content, Snapshot* snapshot) {
  physics::Checkpoint* const parts[] = {&snapshot->node, &snapshot->world, &snapshot->inputs};
  const auto tick = physics::ReadCheckpointFile(file, content, parts);
  if (!tick) return core::Fail(tick.error().code, tick.error().detail);
  snapshot->tick = *tick;
  return {};
}

}  // namespace physics_node
