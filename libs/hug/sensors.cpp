#include "hug/sensors.hpp"

#include <cmath>

namespace hug {

void Sensors::Measure(double dt_s, double time_s, const ArmTruth& truth, const FaultSwitches& faults) {
  const auto quantized = [](double value, double step) { return step * std::round(value / step); };
  const double share = 1.0 - std::exp(-dt_s / figures_.speed_filter_s);
  for (std::size_t i = 0; i < kJoints; ++i) {
    const int joint = static_cast<int>(i);
    double motor = quantized(truth.position[i], figures_.motor_step_rad);
    if (const Fault* jump = faults.Find(FaultKind::kEncoderJump, joint, time_s)) motor += jump->amount;
    if (!is_first_ && faults.Find(FaultKind::kStuckSensor, joint, time_s) != nullptr) motor = before_[i];
    readings_.motor_position[i] = motor;
    readings_.link_position[i] = quantized(truth.position[i], figures_.link_step_rad);
    if (!is_first_) readings_.speed[i] += share * ((motor - before_[i]) / dt_s - readings_.speed[i]);
    before_[i] = motor;
    readings_.torque[i] = truth.link_torque[i] + figures_.torque_noise_Nm * noise_.Normal();
    readings_.second_torque[i] = truth.link_torque[i] + figures_.torque_noise_Nm * noise_.Normal();
    if (const Fault* bias = faults.Find(FaultKind::kTorqueBias, joint, time_s)) readings_.torque[i] += bias->amount;
  }
  is_first_ = false;
  readings_.F_Do_W = truth.F_Do_W;
  for (int c = 0; c < 3; ++c) {
    readings_.F_Do_W.force_N[c] += figures_.force_noise_N * noise_.Normal();
    readings_.F_Do_W.torque_Nm[c] += figures_.wrist_torque_noise_Nm * noise_.Normal();
  }
  readings_.F_Do_W.force_N.x += faults.Amount(FaultKind::kForceBias, time_s);
}

FaultCause Sensors::Check(double dt_s, const Joints& link_torque) {
  const double share = 1.0 - std::exp(-dt_s / figures_.force_gap_filter_s);
  // A wrong force shows most in the joint with the longest lever, 0.7 m; 0.5 m are asked for.
  constexpr double kLever_m = 0.5;
  FaultCause cause = FaultCause::kNone;
  for (std::size_t i = 0; i < kJoints; ++i) {
    torque_gap_[i] += share * (readings_.second_torque[i] - link_torque[i] - torque_gap_[i]);
    if (!(std::abs(torque_gap_[i]) < kLever_m * figures_.force_gap_N)) cause = FaultCause::kForceSensor;
  }
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (!(std::abs(readings_.torque[i] - readings_.second_torque[i]) < figures_.torque_gap_Nm)) {
      cause = FaultCause::kTorqueSensors;
    }
  }
  for (std::size_t i = 0; i < kJoints; ++i) {
    if (!(std::abs(readings_.motor_position[i] - readings_.link_position[i]) < figures_.position_gap_rad)) {
      cause = FaultCause::kPositionSensors;
    }
  }
  return cause;
}

}  // namespace hug
