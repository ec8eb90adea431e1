#pragma once

#include <cstdint>

#include "core/pose.hpp"
#include "core/wrench.hpp"

namespace device_bridge {

class SafetyFilter;

// State of a hand device, real or simulated. D is its hand frame.
struct DeviceReading {
  core::Pose X_WD;
  core::Twist V_WD;
  double opening_m = 0.0;
  double opening_velocity_m_per_s = 0.0;
  bool is_engaged = false;  // dead-man held
};

// A force that passed the safety filter. Device::Write takes nothing else, and only SafetyFilter can create one that is
// not zero, so no code can bypass the filter.
class FilteredForce {
 public:
  FilteredForce() = default;  // no force

  [[nodiscard]] const core::Wrench& F_Do_W() const { return F_Do_W_; }
  [[nodiscard]] double grip_force_N() const { return grip_force_N_; }
  // Viscous damping that the device adds in its own, undelayed loop while the force is unreliable. It only dissipates.
  [[nodiscard]] double brake_N_s_per_m() const { return brake_N_s_per_m_; }
  [[nodiscard]] double brake_Nm_s_per_rad() const { return brake_Nm_s_per_rad_; }

 private:
  friend class SafetyFilter;
  core::Wrench F_Do_W_;
  double grip_force_N_ = 0.0;
  double brake_N_s_per_m_ = 0.0;
  double brake_Nm_s_per_rad_ = 0.0;
};

// Interface of real and simulated hand devices. Times are CLOCK_MONOTONIC of this host (virtual in lock-step) and do
// not decrease. Read and Write are called by the real-time thread: they neither block, allocate nor throw.
class Device {
 public:
  virtual ~Device() = default;

  // State at now_ns.
  virtual DeviceReading Read(std::int64_t now_ns) noexcept = 0;

  // Force on the hand from now_ns until the next Write, or until the device's own watchdog expires.
  virtual void Write(std::int64_t now_ns, const FilteredForce& force) noexcept = 0;

  [[nodiscard]] virtual bool is_simulated() const = 0;
  [[nodiscard]] virtual const char* description() const = 0;
};

}  // namespace device_bridge
