#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "nodes/device_bridge/ports.hpp"
#include "nodes/device_bridge/simulated_arm.hpp"
#include "scene/scenario.hpp"

namespace device_bridge {

// A scene as it was at one moment.
struct Sighting {
  std::int64_t time_ns = 0;
  std::vector<core::Pose> X_WO;                  // per object of the scenario
  std::vector<std::uint8_t> is_visible;          // per object: its pose has been heard of (fixed ones always)
  std::vector<core::Pose> X_WHand;               // per role: the palm as it is drawn
  std::vector<std::uint16_t> grasped;            // per role
  std::vector<core::MechanismState> mechanisms;  // per mechanism
  int step = -1;                                 // index into the operator's steps
};

// The simulated operator's eyes: every tick is recorded, and only what is at least `delay_s` old can be looked at.
// Nothing allocates after construction.
class DelayedSight {
 public:
  DelayedSight(const scene::Scenario& scenario, double delay_s);

  // `step`: as logic shows it now. `readings`: where a hand is drawn until its first proxy arrives.
  void Record(const Inputs& inputs, const core::FixedVector<DeviceReading, kMaxRoles>& readings, int step) noexcept;

  // The newest scene that is old enough at now_ns; null while there is none.
  [[nodiscard]] const Sighting* At(std::int64_t now_ns) const noexcept;

 private:
  const scene::Scenario& scenario_;
  std::int64_t delay_ns_;
  std::vector<Sighting> ring_;
  std::size_t newest_ = 0;
  std::size_t size_ = 0;
};

// The operator's sense of force: what was felt `reaction_s` ago.
class DelayedTouch {
 public:
  explicit DelayedTouch(double reaction_s);
  void Record(std::int64_t now_ns, const FeltForce& felt) noexcept;
  [[nodiscard]] FeltForce At(std::int64_t now_ns) const noexcept;  // nothing until it is old enough

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
