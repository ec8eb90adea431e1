#pragma once

#include <cstdint>

#include "nodes/haptic_node/ports.hpp"
#include "nodes/physics_node/ports.hpp"

namespace haptic_physics_node {

// What haptic_node and physics_node give each other within one process: what one's step puts out is the other's input.
// Lock-step uses it, and the process in which both nodes run.
struct HandOver {
  haptic_node::Answer answer;
  physics_node::Cycle cycle;

  // Each numbers and dates the messages in `outputs`, as sending them would: a receiver takes what has a new number.
  // Contacts: the newest per pair, so that a set that is not of this cycle stays.
  void TakeProxies(std::uint64_t number, std::int64_t now_ns, haptic_node::Outputs* outputs);
  void TakeContacts(std::uint64_t number, std::int64_t now_ns, haptic_node::Outputs* outputs);
  void TakeAnswer(std::uint64_t number, std::int64_t now_ns, physics_node::Outputs* outputs);
};

}  // namespace haptic_physics_node
