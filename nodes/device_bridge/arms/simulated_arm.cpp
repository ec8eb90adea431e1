#include "nodes/device_bridge/arms/simulated_arm.hpp"

#include <algorithm>
#include <cmath>

namespace device_bridge {

ArmParameters ArmParameters::From(const scene::Device& device) {
  ArmParameters p;
  p.is_jointed = device.type == "simulated_hug";
  p.mass_kg = device.mass_kg;
  p.inertia_kg_m2 = device.inertia_kg_m2;
  p.damping_N_s_per_m = device.damping_N_s_per_m;
  p.damping_Nm_s_per_rad = device.damping_Nm_s_per_rad;
  p.opening_max_m = device.opening_max_m;
  p.opening_start_m = device.opening_start_m;
  p.command_delay_ns = static_cast<std::int64_t>(std::llround(device.command_delay_s * 1e9));
  p.X_WD_start = device.X_WD_start;
  p.hand.stiffness_N_per_m = device.hand_stiffness_N_per_m;
  p.hand.damping_N_s_per_m = device.hand_damping_N_s_per_m;
  p.hand.stiffness_Nm_per_rad = device.hand_stiffness_Nm_per_rad;
  p.hand.damping_Nm_s_per_rad = device.hand_damping_Nm_s_per_rad;
  return p;
}

SimulatedArm::SimulatedArm(const ArmParameters& parameters) : parameters_(parameters) {
  if (parameters.is_jointed) jointed_.emplace(parameters.X_WD_start);
  state_.X_WD = parameters.X_WD_start;
  state_.opening_m = parameters.opening_start_m;
  state_.is_engaged = true;
  hand_.X_WT = parameters.X_WD_start;
  hand_.opening_m = parameters.opening_start_m;
}

DeviceReading SimulatedArm::Read(std::int64_t now_ns) noexcept {
  AdvanceTo(now_ns);
  state_.is_engaged = hand_.holds_dead_man;
  return state_;
}

void SimulatedArm::Write(std::int64_t now_ns, const MotorForce& force) noexcept {
  AdvanceTo(now_ns);
  last_write_ns_ = now_ns;
  is_braked_ = false;
  if (parameters_.command_delay_ns <= 0) {
    force_ = force;
    return;
  }
  if (pending_size_ == kMaxPending) {  // the delay exceeds the queue: apply the oldest early rather than lose it
    force_ = pending_[pending_begin_].force;
    pending_begin_ = (pending_begin_ + 1) % kMaxPending;
    --pending_size_;
  }
  pending_[(pending_begin_ + pending_size_) % kMaxPending] = {now_ns + parameters_.command_delay_ns, force};
  ++pending_size_;
}

void SimulatedArm::SetHand(const HandTarget& target) noexcept {
  hand_ = target;
}

void SimulatedArm::AdvanceTo(std::int64_t now_ns) noexcept {
  if (!is_started_) {
    is_started_ = true;
    time_ns_ = now_ns;
    last_write_ns_ = now_ns;
  }
  // The step is split where a delayed command becomes due and where the watchdog expires, so neither is rounded to a
  // tick.
  while (time_ns_ < now_ns) {
    std::int64_t until_ns = now_ns;
    const std::int64_t watchdog_ns = last_write_ns_ + parameters_.watchdog_ns;
    if (watchdog_ns <= time_ns_) {
      force_ = MotorForce{};
      pending_size_ = 0;
      // A bridge that does not write does not move the hand's target either, so that stands still.
      is_braked_ = true;
      hand_.V_WT = core::Twist{};
      hand_.opening_velocity_m_per_s = 0.0;
    } else {
      until_ns = std::min(until_ns, watchdog_ns);
      while (pending_size_ > 0 && pending_[pending_begin_].due_ns <= time_ns_) {
        force_ = pending_[pending_begin_].force;
        pending_begin_ = (pending_begin_ + 1) % kMaxPending;
        --pending_size_;
      }
      if (pending_size_ > 0) until_ns = std::min(until_ns, pending_[pending_begin_].due_ns);
    }
    AdvanceBy(static_cast<double>(until_ns - time_ns_) * 1e-9);
    time_ns_ = until_ns;
  }
}

double SimulatedArm::Drag_N_s_per_m() const noexcept {
  return parameters_.damping_N_s_per_m + (is_braked_ ? parameters_.brake_N_s_per_m : force_.brake_N_s_per_m);
}
double SimulatedArm::Drag_Nm_s_per_rad() const noexcept {
  return parameters_.damping_Nm_s_per_rad + (is_braked_ ? parameters_.brake_Nm_s_per_rad : force_.brake_Nm_s_per_rad);
}

void SimulatedArm::AdvanceBy(double dt_s) noexcept {
  if (jointed_) {
    AdvanceJoints(dt_s);
  } else {
    AdvancePoint(dt_s);
  }
  AdvanceOpening(dt_s);
}

void SimulatedArm::AdvanceJoints(double dt_s) noexcept {
  const HandImpedance& hand = parameters_.hand;
  const JointedArm::Grip grip{hand_.X_WT,
                              hand_.V_WT,
                              hand.stiffness_N_per_m,
                              hand.damping_N_s_per_m,
                              hand.stiffness_Nm_per_rad,
                              hand.damping_Nm_s_per_rad,
                              Drag_N_s_per_m(),
                              Drag_Nm_s_per_rad()};
  jointed_->Advance(dt_s, force_.F_Do_W, grip);
  state_.X_WD = jointed_->X_WD();
  state_.V_WD = jointed_->V_WD();
  MoveTarget(dt_s);
}

void SimulatedArm::MoveTarget(double dt_s) noexcept {
  hand_.X_WT.translation += hand_.V_WT.linear_m_per_s * dt_s;
  hand_.X_WT.rotation =
      glm::normalize(core::QuaternionFromRotationVector(hand_.V_WT.angular_rad_per_s * dt_s) * hand_.X_WT.rotation);
}

// The equations of simulated_arm.hpp, solved exactly for a step with constant F and v_T.
void SimulatedArm::AdvancePoint(double dt_s) noexcept {
  const HandImpedance& hand = parameters_.hand;
  const double drag_N_s_per_m = Drag_N_s_per_m();
  const double drag_Nm_s_per_rad = Drag_Nm_s_per_rad();
  const Oscillator linear{parameters_.mass_kg, drag_N_s_per_m + hand.damping_N_s_per_m, hand.stiffness_N_per_m};
  const Oscillator angular{parameters_.inertia_kg_m2, drag_Nm_s_per_rad + hand.damping_Nm_s_per_rad,
                           hand.stiffness_Nm_per_rad};

  const glm::dvec3 phi = core::RotationVector(state_.X_WD.rotation * glm::conjugate(hand_.X_WT.rotation));
  glm::dvec3 phi_next;
  for (int i = 0; i < 3; ++i) {
    const double v_T = hand_.V_WT.linear_m_per_s[i];
    const OscillatorState y{state_.X_WD.translation[i] - hand_.X_WT.translation[i],
                            state_.V_WD.linear_m_per_s[i] - v_T};
    const OscillatorState next = StepExactly(linear, y, force_.F_Do_W.force_N[i] - drag_N_s_per_m * v_T, dt_s);
    state_.X_WD.translation[i] = hand_.X_WT.translation[i] + v_T * dt_s + next.position;
    state_.V_WD.linear_m_per_s[i] = v_T + next.velocity;

    const double w_T = hand_.V_WT.angular_rad_per_s[i];
    const OscillatorState next_angle = StepExactly(angular, {phi[i], state_.V_WD.angular_rad_per_s[i] - w_T},
                                                   force_.F_Do_W.torque_Nm[i] - drag_Nm_s_per_rad * w_T, dt_s);
    phi_next[i] = next_angle.position;
    state_.V_WD.angular_rad_per_s[i] = w_T + next_angle.velocity;
  }
  MoveTarget(dt_s);
  state_.X_WD.rotation = glm::normalize(core::QuaternionFromRotationVector(phi_next) * hand_.X_WT.rotation);
}

// With the opening o [m], its target o_T, finger stiffness K and strength S, the fingers' force is
//   K (o_T - o) while |K (o_T - o)| <= S, else S sign(o_T - o), plus damping.
// The case is decided at the start of a step; each case is solved exactly.
void SimulatedArm::AdvanceOpening(double dt_s) noexcept {
  const HandImpedance& hand = parameters_.hand;
  const double drag = parameters_.jaw_damping_N_s_per_m + force_.brake_N_s_per_m;
  const double spring_N = hand.finger_stiffness_N_per_m * (hand_.opening_m - state_.opening_m);
  const bool is_saturated = std::abs(spring_N) > hand_.grip_strength_N;
  const double stiffness = is_saturated ? 0.0 : hand.finger_stiffness_N_per_m;
  const double finger_N = is_saturated ? std::copysign(hand_.grip_strength_N, spring_N) : 0.0;
  const double v_T = hand_.opening_velocity_m_per_s;
  const Oscillator axis{parameters_.jaw_mass_kg, drag + hand.finger_damping_N_s_per_m, stiffness};
  const OscillatorState next =
      StepExactly(axis, {state_.opening_m - hand_.opening_m, state_.opening_velocity_m_per_s - v_T},
                  force_.grip_force_N + finger_N - drag * v_T, dt_s);
  hand_.opening_m += v_T * dt_s;
  const double opening_m = hand_.opening_m + next.position;
  state_.opening_m = std::clamp(opening_m, 0.0, parameters_.opening_max_m);
  state_.opening_velocity_m_per_s = opening_m == state_.opening_m ? v_T + next.velocity : 0.0;  // end stops
}

core::Wrench SimulatedArm::HandWrench() const noexcept {
  return device::HandWrench(parameters_.hand, hand_.X_WT, hand_.V_WT, state_.X_WD, state_.V_WD);
}

double SimulatedArm::FingerSpringForce() const noexcept {
  const double spring_N = parameters_.hand.finger_stiffness_N_per_m * (hand_.opening_m - state_.opening_m);
  return std::clamp(spring_N, -hand_.grip_strength_N, hand_.grip_strength_N);
}

FeltForce SimulatedArm::Felt() const noexcept {
  return {force_.F_Do_W, HandWrench(), force_.grip_force_N, FingerSpringForce(), state_.opening_m};
}

}  // namespace device_bridge
