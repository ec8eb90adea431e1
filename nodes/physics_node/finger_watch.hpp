#pragma once

#include <array>
#include <vector>

#include "nodes/physics_node/build_world.hpp"
#include "nodes/physics_node/ports.hpp"
#include "physics/checkpoint.hpp"

namespace physics_node {

// What each hand with fingers holds, as procedures and people are told: what its thumb and another finger press on.
// Nothing follows from it for the motion: fingers hold by their contacts and their friction alone.
//
// As for jaws (GraspKeeper), an object counts as held after GraspKeeper::kPressTicks and as lost after kLostTicks.
class FingerWatch {
 public:
  explicit FingerWatch(const BuiltWorld* built);

  // After each step of the world.
  void Update(std::size_t role);
  // Object index; kNone: nothing.
  [[nodiscard]] int held_by(std::size_t role) const { return held_[role]; }

  void ExchangeState(physics::Checkpoint* checkpoint);

 private:
  [[nodiscard]] bool IsPressed(const std::vector<int>& contacts) const;

  const BuiltWorld* built_;
  std::vector<int> ticks_;  // per finger hold: how long it has been pressed, or lost while it is held
  std::array<int, kMaxRoles> held_{};
};

}  // namespace physics_node
