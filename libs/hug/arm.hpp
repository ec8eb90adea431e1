#pragma once

#include <optional>
#include <span>
#include <vector>

#include "hug/arm_control.hpp"
#include "hug/clutch.hpp"
#include "hug/gripper_axis.hpp"

namespace hug {

struct ArmFigures {
  core::Pose X_WB;  // of the arm's own base
  ControlFigures control;
  SensorFigures sensors;
  SafetyTimes safety;
  ClutchFigures clutch;
  HandImpedance hand;
  HandMount mount;
  double command_delay_s = 0.0;
  double opening_max_m = 0.08;
  double opening_start_m = 0.06;
  std::vector<Fault> faults;
  std::uint64_t seed = 1;
};

// What a viewer shows of an arm.
struct ArmStatus {
  Joints position{}, speed{};
  Joints measured_Nm{}, commanded_Nm{};
  Joints temperature_degC{};
  std::optional<Joints> target;
  SafetyState state = SafetyState::kOff;
  FaultCause first_cause = FaultCause::kNone;
  bool is_clutch_closed = false;
  bool is_at_limit = false;
  double least_distance_m = 1e9;  // to the other arm and to bodies
};

// A SIMULATED arm of HUG with its joint loop, 3000 steps a second of a clock that its caller advances: rigid links with
// weight, rotors and friction (physics::Chain), the operator's hand at the clutch, sensors, control and safety states.
class Arm {
 public:
  static constexpr double kStep_s = 1.0 / 3000.0;

  explicit Arm(const ArmFigures& figures);

  // Moves to the start pose, from the ready posture, turned by a fitting mount of the gripper. False: the arm does not
  // reach it.
  bool Start(const core::Pose& X_WD);

  void Send(const ArmCommand& command) { link_.Send(time_s_, command, faults_); }
  void SetHand(const Hand& hand) { hand_ = hand; }

  // The step in two halves, between which the machine looks at both arms: first the sensors, then control and motion.
  void Sense();
  void Move(const Joints& avoidance, double least_distance_m);

  [[nodiscard]] const ArmDynamics& measured() const { return model_; }  // placed by the sensors
  [[nodiscard]] const Joints& measured_speed() const { return sensors_.readings().speed; }
  [[nodiscard]] core::Pose X_WD() const { return model_.X_WD(); }  // as measured
  [[nodiscard]] core::Twist V_WD() const { return model_.V_WD(); }
  [[nodiscard]] core::Wrench motors_F_Do_W() const;  // that act now: the command's share, and what leads
  [[nodiscard]] const core::Wrench& hand_F_Do_W() const { return F_hand_; }
  [[nodiscard]] const GripperAxis& gripper() const { return gripper_; }
  [[nodiscard]] double motor_grip_N() const { return grip_N_; }
  [[nodiscard]] const SafetyStates& safety() const { return safety_; }
  [[nodiscard]] bool is_unplugged() const { return faults_.is_on(FaultKind::kUnplug, time_s_); }
  [[nodiscard]] const ArmStatus& status() const { return status_; }
  [[nodiscard]] double time_s() const { return time_s_; }
  // In mode kGuidance.
  void Lead(const LeadGoal& goal) { control_.Lead(goal); }
  void StopLeading() { control_.StopLeading(); }

  [[nodiscard]] const Readings& readings() const { return sensors_.readings(); }

  // The truth, for tests.
  [[nodiscard]] const physics::ChainState& truth() const { return state_; }
  // A body that the hand holds rigidly beyond the mount, at D; its inertia is the same about each axis.
  void HoldBody(double mass_kg, double inertia_kg_m2);
  void HoldMass(double mass_kg) { HoldBody(mass_kg, 0.0); }
  // A force of the hand beside its spring.
  void PushBy(const core::Wrench& F_Do_W) { push_ = F_Do_W; }

 private:
  [[nodiscard]] ArmTruth Truth() const;
  void StepSafety();
  void Integrate();
  void Heat();

  ArmFigures figures_;
  ArmModel description_;
  physics::Chain chain_;
  physics::ChainState state_;
  std::vector<core::Wrench> wrenches_;
  std::vector<double> torques_;
  physics::ChainAcceleration accelerations_;
  ArmDynamics model_;
  Sensors sensors_;
  ArmControl control_;
  CommandLink link_;
  FaultSwitches faults_;
  SafetyStates safety_;
  Clutch clutch_;
  GripperAxis gripper_;
  Hand hand_;
  core::Wrench push_;
  core::Wrench F_hand_;   // of the hand, beyond the sensor
  core::Wrench F_wrist_;  // at the sensor, without weight
  Joints link_torque_{};
  Joints acceleration_{};  // mean of the latest step
  double held_kg_ = 0.0;
  double held_kg_m2_ = 0.0;
  double grip_N_ = 0.0;
  double time_s_ = 0.0;
  std::uint64_t num_steps_ = 0;
  FaultCause fault_ = FaultCause::kNone;
  ArmStatus status_;
};

}  // namespace hug
