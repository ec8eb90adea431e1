#pragma once

#include "core/fixed_vector.hpp"
#include "core/messages/device.hpp"
#include "core/messages/haptic.hpp"
#include "core/messages/logic.hpp"
#include "core/messages/physics.hpp"

namespace device_bridge {

constexpr std::size_t kMaxRoles = 4;
constexpr std::size_t kMaxViewers = 4;  // that can steer a hand

// Inputs of one tick. A message with header.sequence 0 has never arrived.
struct Inputs {
  std::int64_t now_ns = 0;
  core::FixedVector<core::DeviceCommand, kMaxRoles> commands;      // newest per role
  core::FixedVector<std::int64_t, kMaxRoles> command_received_ns;  // on this node's clock
  // Only for the simulated operator, which sees them delayed.
  core::FixedVector<core::HapticProxy, kMaxRoles> proxies;
  const core::PhysicsState* physics = nullptr;
  core::FixedVector<std::uint16_t, kMaxRoles> grasped_objects;
  const core::LogicStatus* logic = nullptr;
  // Only for a person without a device: newest of each viewer.
  core::FixedVector<core::HandInput, kMaxViewers> hands;
};

struct Outputs {
  core::FixedVector<core::DeviceState, kMaxRoles> states;     // one per role
  core::FixedVector<core::Wrench, kMaxRoles> applied;         // written to the device, after the safety filter
  core::FixedVector<std::uint32_t, kMaxRoles> filter_status;  // FilterStatus bit set
};

}  // namespace device_bridge
