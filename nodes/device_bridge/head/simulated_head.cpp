#include "nodes/device_bridge/head/simulated_head.hpp"

#include <cmath>
#include <numbers>

#include "core/clock.hpp"

namespace device_bridge {
namespace {

constexpr double kNatural_rad_per_s = 2.0 * std::numbers::pi * 0.6, kDampingRatio = 0.9;
constexpr double kReach[] = {0.12, 0.06, 0.03, 0.10, 0.06, 0.25};  // of aims, to either side: x, y, z, about x, y, z
constexpr double kShortest_s = 1.5, kLongest_s = 4.0;              // at one place
constexpr double kSway_m = 0.002;                                  // root mean square, along each axis

// y'' + 2 d w y' + w^2 y = f: a unit mass.
constexpr Oscillator kBody{1.0, 2.0 * kDampingRatio* kNatural_rad_per_s, kNatural_rad_per_s* kNatural_rad_per_s};

// White noise of the power S moves the mass by s^2 = S / (4 d w^3); as a force that is constant over a step it has the
// variance S / dt.
double SwayForce() {
  const double w = kNatural_rad_per_s;
  return kSway_m * std::sqrt(4.0 * kDampingRatio * w * w * w / core::kTick_s);
}

}  // namespace

SimulatedHead::SimulatedHead(std::uint64_t seed) : random_(seed) {}

void SimulatedHead::Step() noexcept {
  if (ticks_ >= next_aim_tick_) {
    for (std::size_t i = 0; i < kNumAxes; ++i) aims_[i] = random_.Uniform(-kReach[i], kReach[i]);
    next_aim_tick_ = ticks_ + static_cast<std::int64_t>(random_.Uniform(kShortest_s, kLongest_s) / core::kTick_s);
  }
  static const double sway_force = SwayForce();
  for (std::size_t i = 0; i < kNumAxes; ++i) {
    const double sway = i < 3 ? sway_force * random_.Gaussian() : 0.0;
    axes_[i] = StepExactly(kBody, axes_[i], kBody.stiffness * aims_[i] + sway, core::kTick_s);
  }
  ++ticks_;
}

std::optional<core::Pose> SimulatedHead::Read(std::int64_t now_ns) noexcept {
  if (begin_ns_ < 0) begin_ns_ = now_ns;
  while (ticks_ * core::kTick_ns < now_ns - begin_ns_) Step();
  const auto at = [&](std::size_t first) {
    return glm::dvec3(axes_[first].position, axes_[first + 1].position, axes_[first + 2].position);
  };
  return core::Pose{core::QuaternionFromRollPitchYaw(at(3)), at(0)};
}

}  // namespace device_bridge
