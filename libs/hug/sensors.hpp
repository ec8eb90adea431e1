#pragma once

#include "core/wrench.hpp"
#include "hug/faults.hpp"
#include "hug/joints.hpp"
#include "hug/noise.hpp"
#include "hug/safety_states.hpp"

namespace hug {

// What is true in an arm, for the sensors to measure.
struct ArmTruth {
  Joints position{};
  Joints link_torque{};  // between gear and link
  core::Wrench F_Do_W;   // of the hand on the arm, through the wrist's sensor, the weight of what is mounted taken off
};

// What the sensors say. Each joint has two of position and two of torque.
struct Readings {
  Joints motor_position{};  // fine, behind the gear: what the control uses
  Joints link_position{};
  Joints speed{};  // of the motor's sensor, filtered
  Joints torque{};
  Joints second_torque{};
  core::Wrench F_Do_W;
};

struct SensorFigures {
  double link_step_rad = 9.587e-5;   // 2 pi / 65 536
  double motor_step_rad = 9.587e-7;  // the same behind a gear of 100; assumed
  // Root mean squares; assumed.
  double torque_noise_Nm = 0.1;
  double force_noise_N = 0.1;
  double wrist_torque_noise_Nm = 0.005;
  double speed_filter_s = 1e-3;  // three steps of the joint loop: leaves a fifth of the noise of a difference
  // How far two sensors may be apart. Position: 50 steps of the coarser one. Torque: 20 times the noise of a
  // difference; at 0.5 good arms are faulted, at 20 a bias of Faults.EachOneIsNoticed* is not noticed. Force: between
  // wrist and joints' torques, filtered: at 5 N a stuck position sensor is taken for a broken force sensor, at 25 N a
  // bias of 20 N is not noticed; the same with a filter of 30 ms, and of 1 s.
  double position_gap_rad = 5e-3;
  double torque_gap_Nm = 3.0;
  double force_gap_N = 10.0;
  double force_gap_filter_s = 0.1;
};

class Sensors {
 public:
  Sensors(const SensorFigures& figures, std::uint64_t seed) : figures_(figures), noise_(seed) {}
  void Measure(double dt_s, double time_s, const ArmTruth& truth, const FaultSwitches& faults);
  // Compares the redundant sensors. `link_torque`: what the model expects in the joints for the measured force.
  [[nodiscard]] FaultCause Check(double dt_s, const Joints& link_torque);
  [[nodiscard]] const Readings& readings() const { return readings_; }

 private:
  SensorFigures figures_;
  Noise noise_;
  Readings readings_;
  Joints before_{};
  Joints torque_gap_{};  // filtered
  bool is_first_ = true;
};

}  // namespace hug
