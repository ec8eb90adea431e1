#pragma once

#include <cstdint>
#include <limits>

#include "core/messages/device.hpp"
#include "core/result.hpp"
#include "nodes/device_bridge/device.hpp"
#include "scene/scenario.hpp"

namespace device_bridge {

// Bit set of what the filter did in a sample. `kNotFinite` is a fault: it stays until the dead-man switch is released
// and pressed again.
enum FilterStatus : std::uint32_t {
  kFilterOk = 0,
  kNoCommand = 1U << 0,  // no command has arrived yet
  kNotFinite = 1U << 1,  // NaN or infinite command or device reading
  kDegraded = 1U << 2,   // no command for longer than the hold: the force fades, the arm is braked
  kSilent = 1U << 3,     // faded out: no force until commands arrive again
  kForceLimited = 1U << 4,
  kTorqueLimited = 1U << 5,
  kRateLimited = 1U << 6,
  kVelocityBraked = 1U << 7,  // above the soft speed limit: arm braked; above the hard limit no force
  kPowerLimited = 1U << 8,
  kDeadMan = 1U << 9,    // dead-man switch not held
  kStarting = 1U << 10,  // start ramp
  kRefused = 1U << 11,   // a command was refused since the last sample: duplicate, old or from the future
  kGripLimited = 1U << 12,
};

// The force is withdrawn or ramped.
constexpr std::uint32_t kForceNotInFull = kNoCommand | kNotFinite | kDegraded | kSilent | kDeadMan | kStarting;

// Limits of the filter. 80 W and 150 N (kAbsoluteMaxForce_N) are those of ISO 10218-1:2006. The times of silence and
// the brake follow from simulating a lost link while a hand presses with 24 N: forces held longer fling the releasing
// hand back, forces cut at once let the pressing hand crash into the wall; device_bridge_test holds the speed below 0.3
// m/s. The other values are judgement: lower ones are safer, higher ones transmit stiffer contacts.
struct FilterLimits {
  double max_force_N = 50.0;
  double max_torque_Nm = 8.0;
  double max_grip_force_N = 50.0;
  double max_force_rate_N_per_s = 20000.0;  // torque: the same share of its limit per second
  double soft_speed_m_per_s = 0.8;
  double max_speed_m_per_s = 1.5;
  double max_power_W = 80.0;                  // from the device into the hand
  std::int64_t hold_ns = 10'000'000;          // the last command is held for this long
  std::int64_t fade_ns = 48'000'000;          // then the force falls linearly to zero, two ticks before 60 ms
  std::int64_t release_fade_ns = 20'000'000;  // after the dead-man switch is released, or a fault
  std::int64_t start_ramp_ns = 1'000'000'000;
  std::int64_t restart_ramp_ns = 200'000'000;  // when commands arrive again after silence
  // Damping by the device itself while degraded and until the force is back in full. A pressing hand moves forward when
  // the force vanishes; the brake holds it near its place for the operator's reaction time of 0.15 s.
  double brake_N_s_per_m = 400.0;
  double brake_Nm_s_per_rad = 4.0;

  static FilterLimits From(const scene::Device& device, double force_cap_N);
};

// The last code before a motor (architecture D15). Stages, in this order: finite, age, dead-man switch and ramps, norm
// limits (direction kept), rate, power, velocity, and the norm again. Limits can be tightened, never loosened, and
// nothing but the filter's output can be written to a device (FilteredForce).
//
// Silence: without a new command the last one is held for 10 ms, then fades to zero over 48 ms while the device brakes,
// so the force is zero before 60 ms. Age counts from the command's arrival on this node's clock, or from the device
// sample that it was computed from if that is older by more than the hold; so a source that repeats an old force counts
// as silent.
class SafetyFilter {
 public:
  // Error: kInvalidInput for limits that are not finite, negative, or above the bounds for all devices.
  static core::Result<SafetyFilter> Create(const FilterLimits& limits);

  // Sets every limit to the smaller of the two values, ramps to the longer. Values that are not finite are ignored.
  void Tighten(const FilterLimits& limits) noexcept;

  // Accepts or refuses a command. Refused commands (a sequence number not above the last one, a validity that is over)
  // do not reset the age; one that is not finite is a fault. `backed_until_ns`: the last message of a process on which
  // the force depends (physics_node); the age counts from there when that is older.
  void Accept(const core::DeviceCommand& command, std::int64_t received_ns,
              std::int64_t backed_until_ns = std::numeric_limits<std::int64_t>::max()) noexcept;

  // The force for the device at now_ns. Calls may come at any interval; a time before the last call's counts as equal.
  // `added` comes to the command before all stages; one that is not finite is left out.
  FilteredForce Apply(std::int64_t now_ns, const DeviceReading& reading, const core::Wrench& added = {}) noexcept;

  [[nodiscard]] std::uint32_t status() const { return status_; }
  [[nodiscard]] bool is_restarting() const { return is_restart_ && gain_ < 1.0; }  // after silence
  [[nodiscard]] std::uint32_t first_cause() const { return first_cause_; }  // of the first loss of force; 0: none yet
  [[nodiscard]] std::int64_t first_cause_ns() const { return first_cause_ns_; }
  [[nodiscard]] const FilterLimits& limits() const { return limits_; }
  [[nodiscard]] std::uint64_t num_accepted() const { return num_accepted_; }
  [[nodiscard]] std::uint64_t num_refused() const { return num_refused_; }
  [[nodiscard]] bool was_accepted() const { return was_accepted_; }  // by the last call of Accept

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
  std::int64_t alive_ns_ = 0;  // start of the age
  std::int64_t hold_ns_ = 0;   // of the newest command
  bool has_command_ = false;
  bool has_fault_ = false;
  bool may_restart_ = false;  // after silence a source may count from 1 again
  bool was_refused_ = false;
  bool was_accepted_ = false;

  double gain_ = 0.0;        // of the start ramp and the dead-man switch, 0 to 1
  bool is_restart_ = false;  // use the shorter ramp, that after silence
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
