#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "nodes/device_bridge/arms/simulated_arm.hpp"
#include "nodes/device_bridge/ports.hpp"
#include "scene/scenario.hpp"

namespace device_bridge {

// The scene at one moment.
struct Sighting {
  std::int64_t time_ns = 0;
  std::vector<core::Pose> X_WO;                  // per object of the scenario
  std::vector<std::uint8_t> is_visible;          // per object: its pose is known (always for fixed ones)
  std::vector<core::Pose> X_WHand;               // per role: the palm's pose as drawn
  std::vector<std::uint16_t> grasped;            // per role
  std::vector<core::MechanismState> mechanisms;  // per mechanism
  int step = -1;                                 // index into the operator's steps
};

// Vision of the simulated operator: records every tick and returns scenes that are at least `delay_s` old. Allocates
// only at construction.
class DelayedSight {
 public:
  DelayedSight(const scene::Scenario& scenario, double delay_s);

  // `step`: the procedure step that logic shows now. `readings`: the hands' poses until their first proxy arrives.
  void Record(const Inputs& inputs, const core::FixedVector<DeviceReading, kMaxRoles>& readings, int step) noexcept;

  // The newest scene that is at least the delay old at now_ns; null while there is none.
  [[nodiscard]] const Sighting* At(std::int64_t now_ns) const noexcept;

 private:
  const scene::Scenario& scenario_;
  std::int64_t delay_ns_;
  std::vector<Sighting> ring_;
  std::size_t newest_ = 0;
  std::size_t size_ = 0;
};

// Sense of force of the simulated operator: the force of `reaction_s` ago.
class DelayedTouch {
 public:
  explicit DelayedTouch(double reaction_s);
  void Record(std::int64_t now_ns, const FeltForce& felt) noexcept;
  [[nodiscard]] FeltForce At(std::int64_t now_ns) const noexcept;  // zero until a sample is old enough

 private:
  struct Sample {
    std::int64_t time_ns = 0;
    FeltForce felt;
  };
  std::int64_t delay_ns_;
  std::vector<Sample> ring_;
  std::size_t newest_ = 0;
  std::size_t size_ = 0;
};

}  // namespace device_bridge
