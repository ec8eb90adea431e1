#pragma once

#include <cstdint>

#include "core/messages/device.hpp"
#include "core/messages/physics.hpp"

namespace lockstep {

// Bit pattern of what a run did: two runs are the same exactly when their hashes are. Only values enter, never padding.
class StateHash {
 public:
  void Add(const core::PhysicsState& state);
  void Add(const core::DeviceCommand& command);
  void Add(const core::DeviceState& device);
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  void Add(const core::Pose& pose);
  void Add(const glm::dvec3& vector);
  void Add(double number);
  void Add(std::uint64_t number);
  std::uint64_t value_ = 0;
};

}  // namespace lockstep
