#pragma once

#include <algorithm>
#include <cmath>

#include "nodes/device_bridge/safety_filter.hpp"

namespace device_bridge {

// For tests: what safety_filter.hpp promises of each sample, checked from outside, by the sample before and the times
// of what was accepted.
class FilterPromises {
 public:
  explicit FilterPromises(const FilterLimits& limits) : limits_(limits) {}

  // A command was accepted that counts as fresh from alive_ns.
  void NoteAccepted(std::int64_t alive_ns) {
    alive_ns_ = std::max(alive_ns, last_ns_ - 3'600'000'000'000);  // none is older than an hour, for its difference
    has_command_ = true;
  }
  // The promise that the sample broke; null: none. Each comparison is false for NaN, too.
  const char* Check(std::int64_t now_ns, const DeviceReading& reading, std::uint32_t status, const FilteredForce& out) {
    now_ns = has_sample_ ? std::max(now_ns, last_ns_) : now_ns;
    const double dt_s =
        has_sample_ ? 1e-9 * static_cast<double>(std::min<std::int64_t>(now_ns - last_ns_, 10'000'000)) : 0.0;
    last_ns_ = now_ns;
    has_sample_ = true;
    const Sizes is{glm::length(out.F_Do_W().force_N), glm::length(out.F_Do_W().torque_Nm),
                   std::abs(out.grip_force_N())};
    const char* broken = CheckSizes(is);
    if (broken == nullptr) broken = CheckBrakes(reading, status, is, out);
    if (broken == nullptr) broken = CheckPower(reading, out);
    if (broken == nullptr) broken = CheckRates(dt_s, status, reading, is, out);
    if (broken == nullptr) broken = CheckWithdrawal(now_ns, dt_s, status, is);
    before_ = out;
    sizes_before_ = is;
    return broken;
  }

 private:
  struct Sizes {
    double force_N = 0.0, torque_Nm = 0.0, grip_N = 0.0;
    [[nodiscard]] bool is_none() const { return force_N < 1e-9 && torque_Nm < 1e-9 && grip_N < 1e-9; }
  };

  [[nodiscard]] const char* CheckSizes(const Sizes& is) const {
    if (!(is.force_N <= limits_.max_force_N)) return "force";
    if (!(is.torque_Nm <= limits_.max_torque_Nm)) return "torque";
    if (!(is.grip_N <= limits_.max_grip_force_N)) return "grip force";
    return nullptr;
  }

  // Brakes are between none and the limit in translation and rotation. They are on above the soft speed and while the
  // force is unreliable; above the hard speed there is nothing else.
  [[nodiscard]] const char* CheckBrakes(const DeviceReading& reading, std::uint32_t status, const Sizes& is,
                                        const FilteredForce& out) const {
    const double linear = out.brake_N_s_per_m(), angular = out.brake_Nm_s_per_rad();
    if (!(linear >= 0.0 && linear <= limits_.brake_N_s_per_m)) return "brake in translation";
    if (!(angular >= 0.0 && angular <= limits_.brake_Nm_s_per_rad)) return "brake in rotation";
    const double speed = glm::length(reading.V_WD.linear_m_per_s);
    const bool must_brake = speed > limits_.soft_speed_m_per_s || (status & (kDegraded | kNotFinite)) != 0;
    if (must_brake && !(linear == limits_.brake_N_s_per_m)) return "brake in translation with speed";
    if (must_brake && !(angular == limits_.brake_Nm_s_per_rad)) return "brake in rotation with speed";
    if (speed > limits_.max_speed_m_per_s && !is.is_none()) return "no force above the hard speed";
    return nullptr;
  }

  [[nodiscard]] const char* CheckPower(const DeviceReading& reading, const FilteredForce& out) const {
    const double power_W = glm::dot(out.F_Do_W().force_N, reading.V_WD.linear_m_per_s) +
                           glm::dot(out.F_Do_W().torque_Nm, reading.V_WD.angular_rad_per_s);
    if (!std::isfinite(power_W)) return nullptr;  // the reading's; without force, as below
    return power_W <= limits_.max_power_W * (1.0 + 1e-9) ? nullptr : "power";
  }

  // A force grows by no more than the rate, and changes by no more unless a later stage takes of it.
  [[nodiscard]] const char* CheckRates(double dt_s, std::uint32_t status, const DeviceReading& reading, const Sizes& is,
                                       const FilteredForce& out) const {
    double share_per_s = limits_.max_force_N > 0.0 ? limits_.max_force_rate_N_per_s / limits_.max_force_N : 0.0;
    if ((status & (kDegraded | kDeadMan | kNotFinite)) != 0) {
      share_per_s = std::max(share_per_s, 1e9 / static_cast<double>(limits_.release_fade_ns));
    }
    const double share = share_per_s * dt_s;
    const double force_N = share * limits_.max_force_N + kRounding;
    const double torque_Nm = share * limits_.max_torque_Nm + kRounding;
    const double grip_N = share * limits_.max_grip_force_N + kRounding;
    if (!(is.force_N <= sizes_before_.force_N + force_N)) return "growth of the force";
    if (!(is.torque_Nm <= sizes_before_.torque_Nm + torque_Nm)) return "growth of the torque";
    if (!(is.grip_N <= sizes_before_.grip_N + grip_N)) return "growth of the grip force";
    constexpr std::uint32_t kTaking = kPowerLimited | kSilent | kNoCommand | kNotFinite | kDegraded | kDeadMan;
    const bool is_taken =
        (status & kTaking) != 0 || glm::length(reading.V_WD.linear_m_per_s) > limits_.max_speed_m_per_s;
    if (is_taken) return nullptr;
    if (!(glm::distance(out.F_Do_W().force_N, before_.F_Do_W().force_N) <= force_N)) return "rate of the force";
    if (!(glm::distance(out.F_Do_W().torque_Nm, before_.F_Do_W().torque_Nm) <= torque_Nm)) return "rate of the torque";
    if (!(std::abs(out.grip_force_N() - before_.grip_force_N()) <= grip_N)) return "rate of the grip force";
    return nullptr;
  }

  // Nothing 60 ms after the last command, and 20 ms after the dead-man was let go or a fault began.
  const char* CheckWithdrawal(std::int64_t now_ns, double dt_s, std::uint32_t status, const Sizes& is) {
    const bool is_silent = !has_command_ || now_ns - alive_ns_ >= 60'000'000;
    if (is_silent && !is.is_none()) return "no force without commands";
    withheld_s_ = (status & (kDeadMan | kNotFinite)) != 0 ? withheld_s_ + dt_s : 0.0;
    const double release_s = 1e-9 * static_cast<double>(limits_.release_fade_ns);
    // The sample in which it was let go is the first that takes away.
    return withheld_s_ > release_s + 1e-6 && !is.is_none() ? "no force after the dead-man was let go" : nullptr;
  }

  static constexpr double kRounding = 1e-9;
  FilterLimits limits_;
  FilteredForce before_;
  Sizes sizes_before_;
  std::int64_t alive_ns_ = 0;
  std::int64_t last_ns_ = 0;
  double withheld_s_ = 0.0;
  bool has_command_ = false;
  bool has_sample_ = false;
};

}  // namespace device_bridge
