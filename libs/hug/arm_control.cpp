#include "hug/arm_control.hpp"

#include <cmath>

#include "hug/feed_forward.hpp"

namespace hug {
namespace {

core::Twist Between(const core::Pose& X_WD, const core::Pose& X_WI) {
  return {core::RotationVector(X_WI.rotation * glm::conjugate(X_WD.rotation)), X_WI.translation - X_WD.translation};
}
core::Twist operator-(const core::Twist& a, const core::Twist& b) {
  return {a.angular_rad_per_s - b.angular_rad_per_s, a.linear_m_per_s - b.linear_m_per_s};
}
core::Wrench Times(double linear, double angular, const core::Twist& twist) {
  return {linear * twist.linear_m_per_s, angular * twist.angular_rad_per_s};
}

}  // namespace

// Weight and Coriolis torques are compensated, and the posture is kept in the null space of J, where it moves the links
// but not the hand. In impedance control, with brakes b and the springs of limits and neighbours tau_s,
//   tau = h(q, q') + M N a_posture + J^T (F_m - b V) + (1 + k) tau_s,   F_m by FeedForward.
Joints ArmControl::Step(const ControlInputs& in, ArmDynamics* arm) {
  const Readings& readings = *in.readings;
  const bool has_force =
      in.state == SafetyState::kEngaging || in.state == SafetyState::kForce || in.state == SafetyState::kDegraded;
  const core::Wrench measured = in.is_clutch_closed ? readings.F_Do_W : core::Wrench{};
  const Joints weight = arm->InverseDynamics({});
  Expect(in, weight, arm);

  Joints springs = LimitTorques(figures_.limits, *arm, readings.motor_position, readings.speed, &is_at_limit_);
  springs = springs + in.avoidance;

  const double rest = has_force ? 1.0 - in.share : 1.0;
  const double brake_N_s_per_m = rest * figures_.brake_N_s_per_m + (has_force ? in.command.brake_N_s_per_m : 0.0);
  const double brake_Nm_s_per_rad =
      rest * figures_.brake_Nm_s_per_rad + (has_force ? in.command.brake_Nm_s_per_rad : 0.0);

  const bool follows = figures_.mode == ControlMode::kAdmittance || figures_.mode == ControlMode::kGuidance;
  if (!follows || !has_force) {
    is_following_ = false;
    target_.reset();
    guidance_.Stop();
    F_leading_ = {};
  }
  if (follows && has_force) {
    return weight + springs + Follow(in, measured, springs, brake_N_s_per_m, brake_Nm_s_per_rad, arm);
  }
  const Joints posture = arm->NullSpaceOf(figures_.posture_per_s2 * (arm->model().ready - readings.motor_position) -
                                          figures_.posture_per_s * readings.speed);
  core::Wrench motors = -Times(brake_N_s_per_m, brake_Nm_s_per_rad, arm->V_WD());
  if (has_force) {
    const core::Wrench wanted = figures_.mode == ControlMode::kGravity ? core::Wrench{} : in.share * in.command.F_Do_W;
    motors += FeedForward(wanted, measured, in.share * GainForShare(figures_.share_of_inertia));
  }
  // Springs have to hold against the hand and against the motors that help it.
  const double helped = has_force ? 1.0 + in.share * GainForShare(figures_.share_of_inertia) : 1.0;
  return weight + arm->InertiaTimes(posture) + arm->TorquesOf(motors) + helped * springs;
}

// What the torque sensors should show, behind the rotors: tau = h + M q'' - J^T (F_s + m_p a_D), m_p of the mount,
// which is beyond the wrist's sensor. Accelerations are differences of the measured speeds, whose noise the check's
// filter takes away. Without them a hand that turns round at 1 m/s, or meets the limits at 0.7 m/s, looks like a broken
// sensor: for the 0.1 s of that filter it stops 3 to 5 kg with 35 N.
void ArmControl::Expect(const ControlInputs& in, const Joints& weight, ArmDynamics* arm) {
  const Readings& readings = *in.readings;
  const glm::dvec3 v_WD = arm->V_WD().linear_m_per_s;
  if (!has_speed_before_) v_WD_before_ = v_WD, speed_before_ = readings.speed;
  has_speed_before_ = true;
  const Joints acceleration = (1.0 / in.dt_s) * (readings.speed - speed_before_);
  core::Wrench F = readings.F_Do_W;
  F.force_N += arm->model().mount.mass_kg / in.dt_s * (v_WD - v_WD_before_);
  expected_ = weight + arm->InertiaTimes(acceleration) - arm->TorquesOf(F);
  for (std::size_t i = 0; i < kJoints; ++i) expected_[i] -= arm->model().links[i].rotor_kg_m2 * acceleration[i];
  speed_before_ = readings.speed;
  v_WD_before_ = v_WD;
}

// The measured force is that of the step before. So its rate, filtered at 100 Hz, is added for a step; without it a
// mass of 2 kg at 10 Hz lacks 2.6 N s/m of its damping.
core::Wrench ArmControl::Predict(double dt_s, const core::Wrench& F) {
  constexpr double kFilter_s = 1.6e-3;  // 1 / (2 pi 100 Hz)
  const core::Wrench off = F + -1.0 * slow_;
  slow_ += (dt_s / kFilter_s) * off;
  return F + (dt_s / kFilter_s) * off;
}

void ArmControl::Lead(const LeadGoal& goal) {
  if (figures_.mode != ControlMode::kGuidance || !is_following_) return;
  goal_ = goal;
  guidance_.LeadTo(goal.X_WG);
}

// Command and what leads are together within the limits that came with the goal.
void ArmControl::StepGuidance(const ControlInputs& in) {
  F_leading_ = {};
  if (!guidance_.is_on()) return;
  const core::Wrench commanded = in.share * in.command.F_Do_W;
  const core::Wrench leading = in.share * guidance_.Step(in.dt_s, virtual_body_.X_WD(), virtual_body_.V_WD());
  F_leading_ = Within(commanded + leading, goal_.max_force_N, goal_.max_torque_Nm) + -commanded;
}

// The virtual body V gets all forces, that of the springs as the wrench that they put on the hand, and the arm follows
// it by resolved acceleration [Luh, Walker, Paul 1980]:
//   q'' = J^+ (A_V + kv (V_V - V) + w^2 (X_V - X) - J' q') + N a_posture,   tau = h + M q'' - J^T F_s + friction,
// with kv = 2 d w.
Joints ArmControl::Follow(const ControlInputs& in, const core::Wrench& measured, const Joints& springs,
                          double brake_N_s_per_m, double brake_Nm_s_per_rad, ArmDynamics* arm) {
  if (!is_following_) {
    virtual_body_.Reset(arm->X_WD(), arm->V_WD());
    slow_ = measured;
    filtered_ = arm->V_WD();
  }
  is_following_ = true;
  // What is mounted beyond the sensor takes its share of the hand's force for its own acceleration.
  core::Wrench hand = measured;
  hand.force_N += arm->model().mount.mass_kg * virtual_body_.acceleration().linear_m_per_s;
  hand = Predict(in.dt_s, hand);  // for both: what moves the virtual body, and what the arm is held against
  core::Wrench F = in.share * (in.command.F_Do_W + hand) + arm->WrenchOf(springs);
  StepGuidance(in);
  F += F_leading_;
  VirtualBody body = figures_.body;
  body.damping_N_s_per_m += brake_N_s_per_m;
  body.damping_Nm_s_per_rad += brake_Nm_s_per_rad;
  const core::Twist off = Between(arm->X_WD(), virtual_body_.X_WD());
  // As late as the measured speed is: a difference of the latest two poses, then its filter. Half a step dt between the
  // two would lead the arm by kv dt/2 s^2 / (s^2 + kv s + w^2) of the way: 30 % more damping in rotation at 10 Hz.
  const double share = 1.0 - std::exp(-in.dt_s / figures_.speed_filter_s);
  const core::Twist latest = virtual_body_.mean_V_WD();
  filtered_.angular_rad_per_s += share * (latest.angular_rad_per_s - filtered_.angular_rad_per_s);
  filtered_.linear_m_per_s += share * (latest.linear_m_per_s - filtered_.linear_m_per_s);
  const core::Twist behind = filtered_ - arm->V_WD();
  virtual_body_.Step(in.dt_s, F, body);

  const double w = figures_.tracking_rad_per_s;
  const double kv = 2.0 * figures_.tracking_damping * w;
  core::Twist a = virtual_body_.acceleration() - arm->BiasAcceleration();
  a.linear_m_per_s += kv * behind.linear_m_per_s + w * w * off.linear_m_per_s;
  a.angular_rad_per_s += kv * behind.angular_rad_per_s + w * w * off.angular_rad_per_s;
  const Joints& q = in.readings->motor_position;
  const Joints& speed = in.readings->speed;
  const Joints acceleration =
      arm->PseudoInverseTimes(a) +
      arm->NullSpaceOf(figures_.posture_per_s2 * (arm->model().ready - q) - figures_.posture_per_s * speed);
  const core::Pose& X_WI = guidance_.is_on() ? guidance_.X_WI() : virtual_body_.X_WD();
  target_ = q + arm->PseudoInverseTimes(Between(arm->X_WD(), X_WI));
  // The springs move the virtual body; what the hand does not feel of them moves the elbow.
  Joints torques = arm->InertiaTimes(acceleration) - arm->TorquesOf(hand + arm->WrenchOf(springs));
  for (std::size_t i = 0; i < kJoints; ++i) torques[i] += arm->model().links[i].damping * speed[i];
  return torques;
}

}  // namespace hug
