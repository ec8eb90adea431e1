#pragma once

#include <string>
#include <vector>

#include "core/messages/logic.hpp"
#include "core/messages/physics.hpp"

namespace logic_node {

struct Inputs {
  std::int64_t now_ns = 0;  // bus time
  const core::PhysicsState* physics = nullptr;
  std::vector<std::uint16_t> grasped_objects;  // per role; core::kNoObject: nothing
  std::vector<core::Event> events;             // since the last step
};

struct Outputs {
  core::LogicStatus status;
  bool is_status_changed = false;
  std::vector<core::ParameterChange> changes;  // for the owners: haptic_node, physics_node
  std::vector<core::Event> events;
};

}  // namespace logic_node
