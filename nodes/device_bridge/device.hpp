#pragma once

#include <cstdint>

#include "core/pose.hpp"
#include "core/wrench.hpp"

namespace device_bridge {

class SafetyFilter;

// What a hand device tells, real or simulated. D is its hand frame.
struct DeviceReading {
  core::Pose X_WD;
  core::Twist V_WD;
  double opening_m = 0.0;
  double opening_velocity_m_per_s = 0.0;
  bool is_engaged = false;  // dead-man held
};

// What a device may be given: the only form that Device::Write takes, and only the safety filter can make one with a
// force in it. Code that wants to move a motor has no way round the filter.
class FilteredForce {
 public:
  FilteredForce() = default;  // no force

  [[nodiscard]] const core::Wrench& F_Do_W() const { return F_Do_W_; }
  [[nodiscard]] double grip_force_N() const { return grip_force_N_; }
  // Added by the device's own, undelayed loop: brakes the arm while the force cannot be trusted. Never adds energy.
  [[nodiscard]] double brake_N_s_per_m() const { return brake_N_s_per_m_; }
  [[nodiscard]] double brake_Nm_s_per_rad() const { return brake_Nm_s_per_rad_; }

 private:
  friend class SafetyFilter;
  core::Wrench F_Do_W_;
  double grip_force_N_ = 0.0;
  double brake_N_s_per_m_ = 0.0;
  double brake_Nm_s_per_rad_ = 0.0;
};

// One interface for real and simulated hand devices. Times are CLOCK_MONOTONIC of this host (virtual in lock-step) and
// never go back. Both calls belong to the real-time thread: they neither block, allocate nor throw.
class Device {
 public:
  virtual ~Device() = default;

  // The device as it is at now_ns.
  virtual DeviceReading Read(std::int64_t now_ns) noexcept = 0;

  // What the hand shall feel from now_ns on, until the next Write or until the device's own watchdog.
  virtual void Write(std::int64_t now_ns, const FilteredForce& force) noexcept = 0;

  [[nodiscard]] virtual bool is_simulated() const = 0;
  [[nodiscard]] virtual const char* description() const = 0;
};

}  // namespace device_bridge
