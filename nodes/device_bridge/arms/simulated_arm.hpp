#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "device/hand_impedance.hpp"
#include "nodes/device_bridge/arms/jointed_arm.hpp"
#include "nodes/device_bridge/arms/oscillator.hpp"
#include "nodes/device_bridge/device.hpp"
#include "scene/scenario.hpp"

namespace device_bridge {

// What the motors apply: a force that passed the safety filter.
struct MotorForce {
  core::Wrench F_Do_W;
  double grip_force_N = 0.0;
  double brake_N_s_per_m = 0.0;
  double brake_Nm_s_per_rad = 0.0;
};

using device::HandImpedance;

struct ArmParameters {
  double mass_kg = 1.5;
  double inertia_kg_m2 = 0.03;
  double damping_N_s_per_m = 5.0;
  double damping_Nm_s_per_rad = 0.05;
  double jaw_mass_kg = 0.5;  // apparent mass of the gripper axis with the fingers (assumed)
  double jaw_damping_N_s_per_m = 2.0;
  double opening_max_m = 0.08;
  double opening_start_m = 0.06;
  bool is_jointed = false;  // seven joints instead of a point mass; mass_kg and inertia_kg_m2 are then unused
  std::int64_t command_delay_ns = 0;
  std::int64_t watchdog_ns = 60'000'000;  // without a Write for this long the device drops the force and brakes
  double brake_N_s_per_m = 400.0;         // of the watchdog; as in FilterLimits
  double brake_Nm_s_per_rad = 4.0;
  core::Pose X_WD_start;
  HandImpedance hand;

  static ArmParameters From(const scene::Device& device);
};

// A SIMULATED hand device: DLR's HUG as a rigid body with 6-DoF mass and damping, a gripper axis, and the operator's
// hand as a spring-damper to its target. Every axis is advanced by the exact zero-order-hold solution (no integration
// error), with commands delayed by any time, also fractions of a step.
//
// Translation, per axis of W, with y = x - x_T [m], x_T moving at v_T over the step, device drag b [N s/m] (with brake)
// and the hand's stiffness K_h [N/m] and damping B_h [N s/m]:
//   m y'' + (b + B_h) y' + K_h y = F - b v_T
// Rotation the same, with y = Log(R_WD R_WT^-1) in W and an isotropic inertia. That is exact while the axis of rotation
// is constant, which holds as long as the hand is near its target.
//
// It is a device of its own by arm_plugin. For device type "simulated_hug" an integrated arm of seven joints replaces
// the rigid body (JointedArm).
class SimulatedArm {
 public:
  explicit SimulatedArm(const ArmParameters& parameters);

  // State at now_ns.
  DeviceReading Read(std::int64_t now_ns) noexcept;
  // Force of the motors from now_ns on.
  void Write(std::int64_t now_ns, const MotorForce& force) noexcept;

  // Takes effect from the time of the last Read on.
  void SetHand(const HandTarget& target) noexcept;
  [[nodiscard]] const HandTarget& hand() const { return hand_; }
  [[nodiscard]] FeltForce Felt() const noexcept;

 private:
  struct PendingCommand {
    std::int64_t due_ns = 0;
    MotorForce force;
  };
  static constexpr std::size_t kMaxPending = 512;  // delays of up to 0.5 s at 1 kHz

  void AdvanceTo(std::int64_t now_ns) noexcept;
  [[nodiscard]] double Drag_N_s_per_m() const noexcept;
  [[nodiscard]] double Drag_Nm_s_per_rad() const noexcept;
  void AdvanceBy(double dt_s) noexcept;
  void AdvancePoint(double dt_s) noexcept;
  void AdvanceJoints(double dt_s) noexcept;
  void MoveTarget(double dt_s) noexcept;
  void AdvanceOpening(double dt_s) noexcept;
  [[nodiscard]] core::Wrench HandWrench() const noexcept;
  [[nodiscard]] double FingerSpringForce() const noexcept;

  ArmParameters parameters_;
  std::optional<JointedArm> jointed_;
  HandTarget hand_;
  DeviceReading state_;
  MotorForce force_;  // acting now
  std::array<PendingCommand, kMaxPending> pending_;
  std::size_t pending_begin_ = 0;
  std::size_t pending_size_ = 0;
  std::int64_t time_ns_ = 0;
  std::int64_t last_write_ns_ = 0;
  bool is_braked_ = false;  // by the device's own watchdog
  bool is_started_ = false;
};

}  // namespace device_bridge
