#pragma once

#include <vector>

#include "core/fixed_vector.hpp"
#include "core/messages/device.hpp"
#include "core/messages/haptic.hpp"
#include "core/messages/logic.hpp"
#include "core/messages/physics.hpp"

namespace haptic_node {

constexpr std::size_t kMaxRoles = 4;

struct Inputs {
  std::int64_t now_ns = 0;
  core::FixedVector<core::DeviceState, kMaxRoles> devices;  // newest per role; header.sequence 0: never arrived
  const core::PhysicsState* physics = nullptr;
  core::FixedVector<core::Reaction, kMaxRoles> reactions;  // newest per role
  const core::ParameterChange* changes = nullptr;          // applied at the start of this step
  std::size_t num_changes = 0;
  // Budget of points for collision in this step, if the node has a time budget. In a replay, that of the recorded step;
  // 0: computed from the measured speed of the machine.
  std::uint64_t budget_points = 0;
};

// What physics_node answers, given within the process instead of over the bus.
struct Answer {
  core::PhysicsState state;  // header.sequence 0: none yet
  core::FixedVector<core::Reaction, kMaxRoles> reactions;
  std::int64_t received_ns = 0;
};

// Work of one step: exact integers, the same for any number of workers (architecture D13).
struct Counters {
  std::uint32_t pairs_considered = 0;
  std::uint32_t pairs_inactive = 0;  // by state matrix
  std::uint32_t pairs_coherent = 0;  // skipped, as they cannot touch yet (temporal coherence)
  std::uint32_t pairs_tested = 0;
  std::uint32_t pairs_in_contact = 0;
  std::uint32_t pairs_cut_short = 0;  // for lack of time, tested only at their deepest places
  std::uint32_t pairs_late = 0;       // for lack of time, postponed to the next cycle, which takes the oldest first
  std::uint32_t oldest_result_cycles = 0;
  std::uint64_t budget_points = 0;  // for collision; 0: no limit
  std::uint64_t spheres_tested = 0;
  std::uint64_t points_tested = 0;
  std::uint64_t points_colliding = 0;
};

struct Outputs {
  core::FixedVector<core::DeviceCommand, kMaxRoles> commands;
  core::FixedVector<core::HapticProxy, kMaxRoles> proxies;
  std::vector<core::ContactSet> contacts;      // one slot per scenario pair, allocated once
  std::vector<std::uint8_t> contacts_updated;  // 1: written in this step, to be sent
  core::CollisionMatrix collisions;
  bool is_collisions_updated = false;  // to be sent
  bool is_in_contact = false;
  Counters counters;
};

}  // namespace haptic_node
