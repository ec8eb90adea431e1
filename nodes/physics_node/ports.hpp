#pragma once

#include <vector>

#include "core/fixed_vector.hpp"
#include "core/messages/haptic.hpp"
#include "core/messages/logic.hpp"
#include "core/messages/physics.hpp"

namespace physics_node {

constexpr std::size_t kMaxRoles = 4;
constexpr std::size_t kMaxEventsPerTick = 16;

struct Inputs {
  std::int64_t now_ns = 0;
  core::FixedVector<core::HapticProxy, kMaxRoles> proxies;  // newest per role
  const core::ContactSet* contacts = nullptr;  // newest per scenario pair (index = pair); sequence 0: never
  std::size_t num_contacts = 0;
  const core::ParameterChange* changes = nullptr;  // to apply at the top of this tick
  std::size_t num_changes = 0;
};

struct Outputs {
  core::PhysicsState state;
  core::FixedVector<core::Reaction, kMaxRoles> reactions;
  std::vector<core::Event> events;  // attach, detach, engage, release: rare; cleared by the node each tick
};

}  // namespace physics_node
