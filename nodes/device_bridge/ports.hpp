#pragma once

#include "core/fixed_vector.hpp"
#include "core/messages/device.hpp"
#include "core/messages/haptic.hpp"
#include "core/messages/logic.hpp"
#include "core/messages/physics.hpp"

namespace device_bridge {

constexpr std::size_t kMaxRoles = 4;

// What one tick of the bridge reads. A message with header.sequence 0 has never arrived.
struct Inputs {
  std::int64_t now_ns = 0;
  core::FixedVector<core::DeviceCommand, kMaxRoles> commands;      // newest per role
  core::FixedVector<std::int64_t, kMaxRoles> command_received_ns;  // on this node's clock
  core::FixedVector<core::HapticProxy, kMaxRoles> proxies;         // seen by the simulated operator, delayed
  const core::PhysicsState* physics = nullptr;                     // seen by the simulated operator, delayed
  core::FixedVector<std::uint16_t, kMaxRoles> grasped_objects;     // seen by the simulated operator, delayed
  const core::LogicStatus* logic = nullptr;                        // step and lamps, seen delayed
};

struct Outputs {
  core::FixedVector<core::DeviceState, kMaxRoles> states;     // one per role
  core::FixedVector<core::Wrench, kMaxRoles> applied;         // after the safety filter: what the device was given
  core::FixedVector<std::uint32_t, kMaxRoles> filter_status;  // FilterStatus bit set
};

}  // namespace device_bridge
