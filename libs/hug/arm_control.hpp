#pragma once

#include <cstdint>
#include <optional>

#include "hug/admittance.hpp"
#include "hug/arm_dynamics.hpp"
#include "hug/command_link.hpp"
#include "hug/guidance.hpp"
#include "hug/safety_states.hpp"
#include "hug/sensors.hpp"
#include "hug/soft_limits.hpp"

namespace hug {

enum class ControlMode : std::uint8_t {
  kGravity,     // weight compensated and no more: the arm is led by the hand
  kImpedance,   // the wanted force, with feed-forward of the measured one
  kAdmittance,  // the measured force moves a virtual body, which the arm follows
  kGuidance     // and a spring leads the virtual body along a trajectory
};

struct ControlFigures {
  ControlMode mode = ControlMode::kImpedance;
  double share_of_inertia = 0.3;  // left by feed-forward, as published for HUG
  VirtualBody body;
  SoftLimits limits;
  // Of the tracking of the virtual body: two poles at 15 Hz, far below the joint loop's 3 kHz. What is rendered does
  // not depend on them, since the arm is told the virtual body's acceleration: HugArm.AdmittanceRenders* pass from 3.7
  // to 60 Hz. Lower ones let the model's errors show, higher ones ask more torque for the sensors' noise. Damping: an
  // overshoot of 0.15 %, exp(-pi d / sqrt(1 - d^2)).
  double tracking_rad_per_s = 94.0;
  double tracking_damping = 0.9;
  double speed_filter_s = 1e-3;  // as SensorFigures'
  // Of the free motion that a seventh joint leaves: back to the ready posture, critically damped (9 = 2 sqrt(20)), to 1
  // % within 1.5 s. A free choice: the hand does not feel it, faster takes torque from what it does feel, and tests
  // pass from none to 500 and 45.
  double posture_per_s2 = 20.0;
  double posture_per_s = 9.0;
  double brake_N_s_per_m = 400.0;   // without force, as in the bridge's filter
  double brake_Nm_s_per_rad = 4.0;  // the same
  GuidanceFigures guidance;
};

// Where the hand is led, and the most of force and torque that leads, the command included.
struct LeadGoal {
  core::Pose X_WG;
  double max_force_N = 0.0;
  double max_torque_Nm = 0.0;
};

struct ControlInputs {
  double dt_s = 0.0;
  const Readings* readings = nullptr;
  ArmCommand command;
  SafetyState state = SafetyState::kOff;
  double share = 0.0;  // of force and feed-forward, while engaging
  bool is_clutch_closed = false;
  Joints avoidance{};  // torques against collisions
};

// The law of one arm's joint loop: torques of the motors from sensors and command.
class ArmControl {
 public:
  explicit ArmControl(const ControlFigures& figures) : figures_(figures), guidance_(figures.guidance) {}

  // `arm`: placed at the measured posture.
  Joints Step(const ControlInputs& in, ArmDynamics* arm);

  // Leads to the goal from now on, on a path of its own; in mode kGuidance, and where there is force.
  void Lead(const LeadGoal& goal);
  void StopLeading() { guidance_.Stop(); }
  // What leads, about Do in W: its share that acts now.
  [[nodiscard]] const core::Wrench& leading_F_Do_W() const { return F_leading_; }
  // Joint angles of where the interpolator or the virtual body wants the arm; none in other modes.
  [[nodiscard]] const std::optional<Joints>& target() const { return target_; }
  // Torques in the joints for the measured force and motion.
  [[nodiscard]] const Joints& expected_link_torque() const { return expected_; }
  [[nodiscard]] bool is_at_limit() const { return is_at_limit_; }

 private:
  Joints Follow(const ControlInputs& in, const core::Wrench& measured, const Joints& springs, double brake_N_s_per_m,
                double brake_Nm_s_per_rad, ArmDynamics* arm);

  void Expect(const ControlInputs& in, const Joints& weight, ArmDynamics* arm);
  [[nodiscard]] core::Wrench Predict(double dt_s, const core::Wrench& F);
  void StepGuidance(const ControlInputs& in);

  ControlFigures figures_;
  Admittance virtual_body_;
  bool is_following_ = false;
  core::Wrench slow_;     // of the measured force, filtered
  core::Twist filtered_;  // velocity of the virtual body, as the measured one
  Guidance guidance_;
  LeadGoal goal_;
  core::Wrench F_leading_;
  std::optional<Joints> target_;
  Joints expected_{};
  bool has_speed_before_ = false;
  Joints speed_before_{};
  glm::dvec3 v_WD_before_{0.0};
  bool is_at_limit_ = false;
};

}  // namespace hug
