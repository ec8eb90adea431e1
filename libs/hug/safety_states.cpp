#include "hug/safety_states.hpp"

#include <algorithm>

namespace hug {

const char* NameOf(SafetyState state) {
  constexpr const char* kNames[] = {"OFF", "IDLE", "READY", "ENGAGING", "FORCE", "DEGRADED", "BRAKE", "FAULT"};
  return kNames[static_cast<int>(state)];
}

const char* NameOf(FaultCause cause) {
  constexpr const char* kNames[] = {
      "none", "not finite", "position sensors", "torque sensors", "force sensor", "clutch", "heat", "speed"};
  return kNames[static_cast<int>(cause)];
}

void SafetyStates::Enter(SafetyState state) {
  state_ = state;
  in_state_s_ = 0.0;
  if (state == SafetyState::kEngaging) share_ = 0.0;
}

void SafetyStates::Step(const SafetyTimes& times, const SafetyInputs& in) {
  in_state_s_ += in.dt_s;
  link_good_s_ = in.command_age_s < times.degraded_age_s ? link_good_s_ + in.dt_s : 0.0;
  if (!in.is_dead_man_held) was_let_go_ = true;
  const FaultCause fault = in.fault != FaultCause::kNone                     ? in.fault
                           : in.hand_speed_m_per_s > times.max_speed_m_per_s ? FaultCause::kSpeed
                                                                             : FaultCause::kNone;
  if (!in.is_powered) {
    link_good_s_ = 0.0;
    if (state_ != SafetyState::kOff) Enter(SafetyState::kOff);
    return;
  }
  if (fault != FaultCause::kNone) {
    if (state_ != SafetyState::kFault) {
      first_cause_ = fault;
      Enter(SafetyState::kFault);
    }
    was_let_go_ = !in.is_dead_man_held;  // it has to be let go after the cause has gone
    in_state_s_ = 0.0;
    return;
  }
  switch (state_) {
    case SafetyState::kOff:
      Enter(SafetyState::kIdle);
      break;
    case SafetyState::kIdle:
      if (link_good_s_ >= times.link_good_s) Enter(SafetyState::kReady);
      break;
    case SafetyState::kReady:
      if (link_good_s_ <= 0.0) {
        Enter(SafetyState::kIdle);
      } else if (in.is_dead_man_held && was_let_go_) {
        Enter(SafetyState::kEngaging);
      }
      break;
    case SafetyState::kEngaging:
    case SafetyState::kForce:
    case SafetyState::kDegraded:
      if (!in.is_dead_man_held || in.command_age_s > times.brake_age_s) {
        Enter(SafetyState::kBrake);
      } else if (state_ == SafetyState::kEngaging && !in.is_clutch_closed) {
        if (in_state_s_ > times.clutch_s) Enter(SafetyState::kReady);
      } else if (state_ == SafetyState::kEngaging) {
        share_ = std::min(1.0, share_ + in.dt_s / times.engaging_s);
        if (share_ >= 1.0) Enter(SafetyState::kForce);
      } else if (in.command_age_s > times.degraded_age_s) {
        if (state_ != SafetyState::kDegraded) Enter(SafetyState::kDegraded);
      } else if (state_ == SafetyState::kDegraded) {
        Enter(SafetyState::kForce);
      }
      break;
    case SafetyState::kBrake:
      // An arm that has stopped is ready again at once; the force comes back over kEngaging.
      if (in.hand_speed_m_per_s < times.stopped_m_per_s) Enter(SafetyState::kReady);
      break;
    case SafetyState::kFault:
      if (was_let_go_ && in.hand_speed_m_per_s < times.stopped_m_per_s && in_state_s_ > times.clutch_s) {
        Enter(SafetyState::kIdle);
      }
      break;
  }
}

}  // namespace hug
