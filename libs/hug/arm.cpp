#include "hug/arm.hpp"

#include <algorithm>
#include <cmath>

namespace hug {
namespace {

constexpr std::size_t kLast = kJoints - 1;

// How fast the brakes in the joints stop an arm; assumed.
constexpr double kBrake_s = 0.015;

// Heating of a motor with its torque, tau^2 R / (tau_max^2), and cooling to the room: at a third of the largest torque
// it reaches 55 degC, at all of it, for long, 340: it is off before. Assumed.
constexpr double kRoom_degC = 23.0;
constexpr double kHeatAtMost_K = 290.0;
constexpr double kCooling_s = 600.0;
constexpr double kTooHot_degC = 90.0;

physics::Chain ChainOf(const ArmModel& model) {
  return std::move(*physics::Chain::Create(model.links));  // cannot fail: the table is valid
}

}  // namespace

Arm::Arm(const ArmFigures& figures)
    : figures_(figures),
      description_(LightWeightRobot(figures.mount)),
      chain_(ChainOf(description_)),
      state_(chain_.MakeState()),
      wrenches_(kJoints),
      torques_(kJoints),
      model_(description_),
      sensors_(figures.sensors, figures.seed),
      control_(figures.control),
      link_(figures.command_delay_s, figures.seed + 17),
      faults_(figures.faults) {
  state_.X_WB = figures.X_WB;
  accelerations_.joint.resize(kJoints);
  std::copy(description_.ready.begin(), description_.ready.end(), state_.position.begin());
  gripper_.opening_m = figures.opening_start_m;
  status_.temperature_degC.fill(kRoom_degC);
}

// Newton's method with the pseudo-inverse. The mount turns the gripper so that the ready posture has the start's
// attitude; then only the place has to be reached.
bool Arm::Start(const core::Pose& X_WD) {
  Joints q = description_.ready;
  model_.Place(figures_.X_WB, q, {});
  figures_.mount.X_FD.rotation =
      glm::normalize(figures_.mount.X_FD.rotation * glm::conjugate(model_.X_WD().rotation) * X_WD.rotation);
  description_ = LightWeightRobot(figures_.mount);
  chain_ = ChainOf(description_);
  model_ = ArmDynamics(description_);
  double off_m = 1.0, off_rad = 1.0;
  for (int i = 0; i < 100 && (off_m > 1e-9 || off_rad > 1e-9); ++i) {
    model_.Place(figures_.X_WB, q, {});
    core::Twist off{core::RotationVector(X_WD.rotation * glm::conjugate(model_.X_WD().rotation)),
                    X_WD.translation - model_.X_WD().translation};
    off_m = glm::length(off.linear_m_per_s);
    off_rad = glm::length(off.angular_rad_per_s);
    // Steps of at most 5 cm and 0.2 rad, and back to the ready posture where the hand does not notice.
    const double shorter = std::min({1.0, 0.05 / std::max(off_m, 1e-12), 0.2 / std::max(off_rad, 1e-12)});
    off.linear_m_per_s *= shorter;
    off.angular_rad_per_s *= shorter;
    q = q + model_.PseudoInverseTimes(off);
    if (i < 60) q = q + 0.1 * model_.NullSpaceOf(description_.ready - q);  // which leaves 1e-4 of itself to the hand
    for (std::size_t k = 0; k < kJoints; ++k) q[k] = std::clamp(q[k], -description_.limit[k], description_.limit[k]);
  }
  std::copy(q.begin(), q.end(), state_.position.begin());
  std::fill(state_.speed.begin(), state_.speed.end(), 0.0);
  hand_.X_WT = X_WD;
  hand_.opening_m = figures_.opening_start_m;
  model_.Place(figures_.X_WB, q, {});
  status_.position = q;
  return off_m < 1e-6 && off_rad < 1e-6;
}

void Arm::HoldBody(double mass_kg, double inertia_kg_m2) {
  held_kg_ = mass_kg;
  held_kg_m2_ = inertia_kg_m2;
  HandMount mount = figures_.mount;
  mount.mass_kg += mass_kg;
  ArmModel model = LightWeightRobot(mount);
  model.links[kLast].mass.I_Cm_O_kg_m2 += inertia_kg_m2 * glm::dmat3(1.0);
  chain_ = ChainOf(model);
}

ArmTruth Arm::Truth() const {
  ArmTruth truth;
  std::copy(state_.position.begin(), state_.position.end(), truth.position.begin());
  truth.link_torque = link_torque_;
  truth.F_Do_W = F_wrist_;
  return truth;
}

void Arm::Sense() {
  if (num_steps_ == 0) {  // nothing moves yet
    model_.Place(figures_.X_WB, status_.position, {});
    link_torque_ = model_.InverseDynamics({});
  }
  sensors_.Measure(kStep_s, time_s_, Truth(), faults_);
  const Readings& readings = sensors_.readings();
  model_.Place(figures_.X_WB, readings.motor_position, readings.speed);
}

void Arm::StepSafety() {
  fault_ = sensors_.Check(kStep_s, num_steps_ == 0 ? link_torque_ : control_.expected_link_torque());
  if (clutch_.Step(figures_.clutch, safety_.is_engaged() && !faults_.is_on(FaultKind::kClutchTrip, time_s_), F_hand_,
                   model_.X_WD(), hand_.X_WT) ||
      (safety_.is_engaged() && faults_.is_on(FaultKind::kClutchTrip, time_s_))) {
    fault_ = FaultCause::kClutch;
  }
  for (const double hot_degC : status_.temperature_degC) {
    if (hot_degC > kTooHot_degC) fault_ = FaultCause::kHeat;
  }
  if (faults_.is_on(FaultKind::kOverheat, time_s_)) fault_ = FaultCause::kHeat;
  const ArmCommand& command = link_.newest();
  if (!std::isfinite(glm::dot(command.F_Do_W.force_N, command.F_Do_W.force_N) +
                     glm::dot(command.F_Do_W.torque_Nm, command.F_Do_W.torque_Nm) + command.grip_force_N +
                     command.brake_N_s_per_m + command.brake_Nm_s_per_rad)) {
    fault_ = FaultCause::kNotFinite;
  }
  SafetyInputs in;
  in.dt_s = kStep_s;
  in.is_powered = !is_unplugged();
  in.is_dead_man_held = hand_.holds_dead_man && !faults_.is_on(FaultKind::kDeadManGlitch, time_s_);
  in.is_clutch_closed = clutch_.is_closed();
  in.command_age_s = link_.age_s(time_s_);
  in.hand_speed_m_per_s = glm::length(model_.V_WD().linear_m_per_s);
  in.fault = fault_;
  safety_.Step(figures_.safety, in);
}

core::Wrench Arm::motors_F_Do_W() const {
  return safety_.is_engaged() ? safety_.share() * link_.newest().F_Do_W + control_.leading_F_Do_W() : core::Wrench{};
}

void Arm::Move(const Joints& avoidance, double least_distance_m) {
  link_.Receive(time_s_);
  StepSafety();
  ControlInputs in;
  in.dt_s = kStep_s;
  in.readings = &sensors_.readings();
  if (fault_ != FaultCause::kNotFinite) in.command = link_.newest();
  in.state = safety_.state();
  in.share = safety_.share();
  in.is_clutch_closed = clutch_.is_closed();
  in.avoidance = avoidance;
  const Joints commanded = control_.Step(in, &model_);
  for (std::size_t i = 0; i < kJoints; ++i) {
    torques_[i] = std::clamp(commanded[i], -description_.max_torque[i], description_.max_torque[i]);
    status_.commanded_Nm[i] = torques_[i];
  }
  grip_N_ = safety_.is_engaged() ? safety_.share() * in.command.grip_force_N : 0.0;
  gripper_.Step(kStep_s, figures_.hand, hand_, clutch_.is_closed(), grip_N_,
                safety_.is_engaged() ? in.command.brake_N_s_per_m : figures_.control.brake_N_s_per_m,
                figures_.opening_max_m);
  Integrate();
  Heat();
  hand_.Move(kStep_s);
  ++num_steps_;
  time_s_ = static_cast<double>(num_steps_) * kStep_s;

  status_.position = in.readings->motor_position;
  status_.speed = in.readings->speed;
  status_.measured_Nm = in.readings->torque;
  status_.target = control_.target();
  status_.state = safety_.state();
  status_.first_cause = safety_.first_cause();
  status_.is_clutch_closed = clutch_.is_closed();
  status_.is_at_limit = control_.is_at_limit();
  status_.least_distance_m = least_distance_m;
}

// One step of the true arm with constant accelerations, which is what held torques give, so that a loop over the arm
// has the delay that it should have. The sensor at the wrist measures what the hand pushes less what accelerates the
// masses beyond it.
void Arm::Integrate() {
  const SafetyState s = safety_.state();
  const bool is_braked =
      s == SafetyState::kOff || s == SafetyState::kIdle || s == SafetyState::kReady || s == SafetyState::kFault;
  chain_.Place(state_);
  const core::Pose X_WF = chain_.X_WL(kLast) * core::Pose{glm::dquat(1, 0, 0, 0), {0.0, 0.0, kFlange_m}};
  const core::Pose X_WD = X_WF * figures_.mount.X_FD;
  const glm::dvec3 r = X_WD.translation - chain_.X_WL(kLast).translation;
  const auto velocity = [&] {
    const core::Twist V = chain_.V_WL(kLast);
    return core::Twist{V.angular_rad_per_s, core::PointVelocity(V, r)};
  };
  const core::Twist before = velocity();
  F_hand_ = push_;
  if (clutch_.is_closed()) F_hand_ += HandWrench(figures_.hand, hand_, X_WD, before);

  Joints speed_before;
  std::copy(state_.speed.begin(), state_.speed.end(), speed_before.begin());
  const glm::dvec3 g_W = figures_.X_WB.rotate({0.0, 0.0, -kGravity_m_per_s2});
  if (is_braked) {
    const double left = std::exp(-kStep_s / kBrake_s);
    for (std::size_t i = 0; i < kJoints; ++i) {
      state_.position[i] += kStep_s * state_.speed[i];
      state_.speed[i] = std::abs(state_.speed[i]) < 1e-4 ? 0.0 : left * state_.speed[i];
    }
    link_torque_ = control_.expected_link_torque();
    F_wrist_ = F_hand_;
    std::fill(torques_.begin(), torques_.end(), 0.0);  // motors have no current
    status_.commanded_Nm.fill(0.0);
    chain_.Place(state_);
    return;
  }
  for (std::size_t i = 0; i < kJoints; ++i) {
    const physics::MassProperties& mass = chain_.link(i).mass;
    wrenches_[i].force_N = mass.mass_kg * g_W;
    wrenches_[i].torque_Nm = glm::cross(chain_.X_WL(i).rotate(mass.p_OCm_m), wrenches_[i].force_N);
  }
  wrenches_[kLast] += core::ShiftWrench(F_hand_, r);
  chain_.Accelerate(state_, torques_, wrenches_, &accelerations_);
  for (std::size_t i = 0; i < kJoints; ++i) {
    const physics::ChainLink& link = chain_.link(i);
    const double a = accelerations_.joint[i];
    const double next = state_.position[i] + kStep_s * (state_.speed[i] + 0.5 * kStep_s * a);
    state_.speed[i] += kStep_s * a;
    state_.position[i] = std::clamp(next, link.lower, link.upper);
    if (next != state_.position[i]) state_.speed[i] = 0.0;  // the end stop
  }
  chain_.Place(state_);
  for (std::size_t i = 0; i < kJoints; ++i) {
    acceleration_[i] = (state_.speed[i] - speed_before[i]) / kStep_s;
    const physics::ChainLink& link = chain_.link(i);
    link_torque_[i] = torques_[i] - link.rotor_kg_m2 * acceleration_[i] - link.damping * state_.speed[i];
  }
  const core::Twist after = velocity();
  const glm::dvec3 a_W = (after.linear_m_per_s - before.linear_m_per_s) / kStep_s;
  F_wrist_ = F_hand_;
  F_wrist_.torque_Nm -= held_kg_m2_ / kStep_s * (after.angular_rad_per_s - before.angular_rad_per_s);
  F_wrist_.force_N -= (figures_.mount.mass_kg + held_kg_) * a_W;
  F_wrist_.force_N += held_kg_ * g_W;  // the weight of the mount is known, that of what is held is not
}

void Arm::Heat() {
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double load = torques_[i] / description_.max_torque[i];
    double& degC = status_.temperature_degC[i];
    degC += kStep_s / kCooling_s * (kHeatAtMost_K * load * load - (degC - kRoom_degC));
  }
}

}  // namespace hug
