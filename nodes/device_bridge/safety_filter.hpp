#pragma once

#include <cstdint>
#include <limits>

#include "core/messages/device.hpp"
#include "core/result.hpp"
#include "nodes/device_bridge/device.hpp"
#include "scene/scenario.hpp"

namespace device_bridge {

// What the filter did in a sample; a bit set. `kNotFinite` is a fault: it stays until the dead-man is let go and held
// again.
enum FilterStatus : std::uint32_t {
  kFilterOk = 0,
  kNoCommand = 1U << 0,  // never had one
  kNotFinite = 1U << 1,  // NaN or infinite command, or a device that reads NaN
  kDegraded = 1U << 2,   // source silent for longer than the hold: force fades, arm braked
  kSilent = 1U << 3,     // faded out: no force until the source speaks again
  kForceLimited = 1U << 4,
  kTorqueLimited = 1U << 5,
  kRateLimited = 1U << 6,
  kVelocityBraked = 1U << 7,  // faster than the soft limit: arm braked; above the hard limit no force either
  kPowerLimited = 1U << 8,
  kDeadMan = 1U << 9,    // not held
  kStarting = 1U << 10,  // start ramp
  kRefused = 1U << 11,   // a command was refused since the last sample: duplicate, old or from the future
  kGripLimited = 1U << 12,
};

struct FilterLimits {
  double max_force_N = 50.0;
  double max_torque_Nm = 8.0;
  double max_grip_force_N = 50.0;
  double max_force_rate_N_per_s = 20000.0;  // torque: the same share of its limit per second
  double soft_speed_m_per_s = 0.8;
  double max_speed_m_per_s = 1.5;
  double max_power_W = 80.0;                  // that the device may put into the hand
  std::int64_t hold_ns = 10'000'000;          // silence that is bridged by the last command
  std::int64_t fade_ns = 48'000'000;          // then linearly to zero, two ticks before 60 ms are over
  std::int64_t release_fade_ns = 20'000'000;  // dead-man let go, or fault
  std::int64_t start_ramp_ns = 1'000'000'000;
  std::int64_t restart_ramp_ns = 200'000'000;  // source speaks again after silence
  // The device's own damping while degraded and until the force is back in full. A hand that pressed falls forward when
  // the force goes; this holds it near where it was until it has noticed (0.15 s).
  double brake_N_s_per_m = 400.0;
  double brake_Nm_s_per_rad = 4.0;

  static FilterLimits From(const scene::Device& device, double force_cap_N);
};

// The last code before a motor (architecture D15). In this order: finite, age, dead-man and ramps, norm limits
// (direction kept), rate, power, velocity, and once more the norm. Its limits can be tightened, never loosened, and
// nothing but its output can be written to a device (FilteredForce).
//
// Silence: the newest command is held for 10 ms, fades to zero over 50 ms more while the device brakes, and is zero
// from 60 ms on. Zero at once would let a pressing hand crash into the wall, holding on would fling a letting-go hand
// out of it. Age counts from the arrival on this node's clock, or from the device sample that the command was computed
// from if that is older by more than the hold: a source that repeats an old force is silent too.
class SafetyFilter {
 public:
  // Fails for limits that are not finite, negative, or beyond what any device here may have.
  static core::Result<SafetyFilter> Create(const FilterLimits& limits);

  // Every limit becomes the smaller of the two; the brake the larger. What is not finite is ignored.
  void Tighten(const FilterLimits& limits) noexcept;

  // Takes a command in. Refused, and no sign of life: a sequence number not above the last one, a validity that is
  // over. Not finite: fault.
  // `backed_until_ns`: last sign of life of what else must run for the force to mean anything (physics); age counts
  // from there when that is older.
  void Accept(const core::DeviceCommand& command, std::int64_t received_ns,
              std::int64_t backed_until_ns = std::numeric_limits<std::int64_t>::max()) noexcept;

  // What the device is given at now_ns. Calls may come at any interval; a clock that goes back counts as standing
  // still.
  FilteredForce Apply(std::int64_t now_ns, const DeviceReading& reading) noexcept;

  [[nodiscard]] std::uint32_t status() const { return status_; }
  [[nodiscard]] bool is_restarting() const { return is_restart_ && gain_ < 1.0; }  // after silence
  [[nodiscard]] std::uint32_t first_cause() const { return first_cause_; }  // of loss of force since the start, kept
  [[nodiscard]] std::int64_t first_cause_ns() const { return first_cause_ns_; }
  [[nodiscard]] const FilterLimits& limits() const { return limits_; }
  [[nodiscard]] std::uint64_t num_accepted() const { return num_accepted_; }
  [[nodiscard]] std::uint64_t num_refused() const { return num_refused_; }
  [[nodiscard]] bool was_accepted() const { return was_accepted_; }  // the last Accept

 private:
  explicit SafetyFilter(const FilterLimits& limits) : limits_(limits) {}
  [[nodiscard]] double AgeFactor(std::int64_t now_ns) noexcept;
  void AdvanceGain(std::int64_t dt_ns, bool may_act) noexcept;

  FilterLimits limits_;
  core::Wrench command_;
  double grip_command_N_ = 0.0;
  std::uint64_t last_sequence_ = 0;
  std::uint64_t streak_sequence_ = 0;
  int restart_streak_ = 0;
  std::int64_t alive_ns_ = 0;  // what age counts from
  std::int64_t hold_ns_ = 0;   // of the newest command
  bool has_command_ = false;
  bool has_fault_ = false;
  bool may_restart_ = false;  // after silence a source may count from 1 again
  bool was_refused_ = false;
  bool was_accepted_ = false;

  double gain_ = 0.0;        // start ramp and dead-man, 0 to 1
  bool is_restart_ = false;  // the ramp after silence is the short one
  core::Wrench output_;      // of the last sample
  double grip_output_N_ = 0.0;
  std::int64_t last_ns_ = 0;
  bool has_sample_ = false;

  std::uint32_t status_ = kNoCommand;
  std::uint32_t first_cause_ = 0;
  std::int64_t first_cause_ns_ = 0;
  std::uint64_t num_accepted_ = 0;
  std::uint64_t num_refused_ = 0;
};

}  // namespace device_bridge
