#pragma once

#include <array>

#include "nodes/device_bridge/arms/oscillator.hpp"
#include "nodes/device_bridge/head/head_tracker.hpp"
#include "nodes/device_bridge/random.hpp"

namespace device_bridge {

// A SIMULATED head of a person who sits before a screen: the upper body as a mass on a spring and a damper, which the
// person pulls to another place every few seconds, with the sway of a body that is not held. All figures are assumed,
// none is measured of people. The same seed gives the same movement, whenever it is read.
class SimulatedHead final : public HeadTracker {
 public:
  explicit SimulatedHead(std::uint64_t seed);

  std::optional<core::Pose> Read(std::int64_t now_ns) noexcept override;
  [[nodiscard]] bool is_simulated() const override { return true; }
  [[nodiscard]] const char* description() const override { return "SIMULATED head of a seated person"; }

 private:
  static constexpr std::size_t kNumAxes = 6;  // x, y, z [m]; turns about them [rad]

  void Step() noexcept;

  Random random_;
  std::array<OscillatorState, kNumAxes> axes_{};
  std::array<double, kNumAxes> aims_{};  // where the person wants to be
  std::int64_t begin_ns_ = -1;
  std::int64_t ticks_ = 0;
  std::int64_t next_aim_tick_ = 0;
};

}  // namespace device_bridge
