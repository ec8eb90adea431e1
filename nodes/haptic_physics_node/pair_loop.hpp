#pragma once

#include <atomic>
#include <cstdint>

#include "nodes/haptic_node/node_loop.hpp"
#include "nodes/haptic_physics_node/hand_over.hpp"
#include "nodes/physics_node/node_loop.hpp"

namespace haptic_physics_node {

// The loops of haptic_node and physics_node on one thread: after each cycle of the one, the ticks of the other that are
// due. Both have been given `hand_over`.
class PairLoop {
 public:
  PairLoop(haptic_node::NodeLoop* haptic, physics_node::NodeLoop* physics, HandOver* hand_over)
      : haptic_(*haptic), physics_(*physics), hand_over_(*hand_over) {}

  void Run(const std::atomic<bool>& stop);

 private:
  void MakeTick(const haptic_node::NodeLoop::Tick& tick);

  haptic_node::NodeLoop& haptic_;
  physics_node::NodeLoop& physics_;
  HandOver& hand_over_;
  std::uint64_t num_cycles_ = 0;
};

}  // namespace haptic_physics_node
