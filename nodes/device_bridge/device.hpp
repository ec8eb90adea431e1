#pragma once

#include <cstdint>

#include "core/fixed_vector.hpp"
#include "core/messages/values.hpp"
#include "core/pose.hpp"
#include "core/wrench.hpp"
#include "device/plugin.h"
#include "nodes/device_bridge/device_health.hpp"
#include "nodes/device_bridge/hand.hpp"

namespace device_bridge {

class SafetyFilter;

// Where a device leads the hand, and the most that it may apply in doing so, its command included.
struct LeadGoal {
  core::Pose X_WG;
  double max_force_N = 0.0;
  double max_torque_Nm = 0.0;
};

// State of a hand device, real or simulated. D is its hand frame.
struct DeviceReading {
  core::Pose X_WD;
  core::Twist V_WD;
  double opening_m = 0.0;
  double opening_velocity_m_per_s = 0.0;
  bool is_engaged = false;                                       // dead-man held
  core::FixedVector<double, core::kMaxFingerJoints> finger_rad;  // empty: not known
  std::int64_t sample_ns = 0;  // when the device was like that; 0: at the time of the call
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

// A hand device as the bridge sees it: the table of a plug-in (device/plugin.h), called at once (ImmediateDevice) or by
// a thread of its own (ThreadedDevice). Times are CLOCK_MONOTONIC of this host (virtual in lock-step) and do not
// decrease. All functions are called by the real-time thread: they neither block, allocate nor throw.
class Device {
 public:
  virtual ~Device() = default;

  // State at now_ns.
  virtual DeviceReading Read(std::int64_t now_ns) noexcept = 0;

  // Force on the hand from now_ns until the next Write, or until the device's own watchdog expires. Axes that have no
  // motor by its description get none.
  virtual void Write(std::int64_t now_ns, const FilteredForce& force) noexcept = 0;

  // Of a device with a simulated operator; others ignore the target and give zero. SetHand takes effect from the time
  // of the last Read on.
  virtual void SetHand(const HandTarget& /*target*/) noexcept {}
  [[nodiscard]] virtual FeltForce Felt() const noexcept { return {}; }

  // Whether the device can lead the hand by its own motors. Lead: to there, from the last Read on; null: no longer.
  [[nodiscard]] virtual bool can_lead() const noexcept { return false; }
  virtual void Lead(const LeadGoal* /*goal*/) noexcept {}

  // What is there; grows by one with each device that is plugged in. 0: none yet.
  [[nodiscard]] virtual std::uint64_t num_found() const noexcept = 0;
  [[nodiscard]] virtual const oos_device_description& description() const noexcept = 0;
  [[nodiscard]] virtual const DeviceHealth& Health(std::int64_t now_ns) noexcept = 0;
  // As the device said it, in its base's frame; of the latest call.
  [[nodiscard]] virtual const oos_device_state& state() const noexcept = 0;
  // Whether the device's plug-in gives joints.
  [[nodiscard]] virtual bool is_robot() const noexcept { return false; }
  // Joints of a robot in its base B, as of the latest Read; false: there are none (now).
  virtual bool Joints(oos_device_joints* /*joints*/) noexcept { return false; }
  // Where the base stands, as of the latest Read.
  [[nodiscard]] virtual core::Pose X_WB() const noexcept { return {}; }
  // While muted, a device gets no commands at all: to see its own watchdog.
  virtual void SetMuted(bool /*is_muted*/) noexcept {}

  [[nodiscard]] bool is_simulated() const noexcept { return (description().flags & OOS_DEVICE_IS_SIMULATED) != 0; }
  [[nodiscard]] bool takes_hand() const noexcept { return (description().flags & OOS_DEVICE_TAKES_HAND) != 0; }
};

}  // namespace device_bridge
