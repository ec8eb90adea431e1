#pragma once

#include <vector>

#include "core/fixed_vector.hpp"
#include "core/messages/haptic.hpp"
#include "core/messages/logic.hpp"
#include "core/messages/physics.hpp"
#include "core/messages/reserve_texts.hpp"

namespace physics_node {

constexpr std::size_t kMaxRoles = 4;
constexpr std::size_t kMaxEventsPerTick = 16;
constexpr std::size_t kMaxChangesPerTick = 32;

// Result of a parameter change, in the tick at the start of which it was applied.
struct ChangeOutcome {
  bool is_accepted = false;
  bool is_pending = false;  // ramped or held: the event parameter_settled reports its end
  double injected_J = 0.0;  // energy that it has injected into the scene
};

struct Inputs {
  std::int64_t now_ns = 0;
  core::FixedVector<core::HapticProxy, kMaxRoles> proxies;  // newest per role
  const core::ContactSet* contacts = nullptr;  // newest per scenario pair (index = pair); sequence 0: never
  std::size_t num_contacts = 0;
  const core::ParameterChange* changes = nullptr;  // applied at the start of this tick
  std::size_t num_changes = 0;
};

// The newest cycle of haptic_node, as it arrived.
struct Cycle {
  core::FixedVector<core::HapticProxy, kMaxRoles> proxies;
  std::vector<core::ContactSet> contacts;  // newest per scenario pair; sequence 0: never
  std::int64_t received_ns = 0;
};

struct Outputs {
  Outputs() {
    events.resize(kMaxEventsPerTick);
    for (core::Event& event : events) core::ReserveTexts(&event);
    events.clear();
  }

  core::PhysicsState state;
  core::FixedVector<core::Reaction, kMaxRoles> reactions;
  core::FixedVector<ChangeOutcome, kMaxChangesPerTick> outcomes;  // one per change of the inputs
  // Attach, detach, engage, release: rare. A step writes into the texts that are there already, without allocating.
  core::FixedVector<core::Event, kMaxEventsPerTick> events;
};

}  // namespace physics_node
