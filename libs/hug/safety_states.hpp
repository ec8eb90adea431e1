#pragma once

#include <cstdint>

namespace hug {

// What an arm may do now.
enum class SafetyState : std::uint8_t {
  kOff,       // no power: brakes
  kIdle,      // sensors are read, brakes hold the arm
  kReady,     // the link has been good for a second; the arm waits for the dead-man
  kEngaging,  // clutch closed, force and freedom come over a second
  kForce,
  kDegraded,  // commands are late: the force is held
  kBrake,     // no force, the arm stops
  kFault      // like kBrake, until the cause is gone and the dead-man was let go
};
const char* NameOf(SafetyState state);

enum class FaultCause : std::uint8_t {
  kNone,
  kNotFinite,
  kPositionSensors,  // the two of a joint disagree
  kTorqueSensors,
  kForceSensor,  // at the wrist; disagrees with the joints' torques
  kClutch,       // came off
  kHeat,
  kSpeed
};
const char* NameOf(FaultCause cause);

struct SafetyInputs {
  double dt_s = 0.0;
  bool is_powered = true;
  bool is_dead_man_held = false;
  bool is_clutch_closed = false;
  double command_age_s = 1e9;
  double hand_speed_m_per_s = 0.0;
  FaultCause fault = FaultCause::kNone;  // now
};

struct SafetyTimes {
  double link_good_s = 1.0;        // a free choice: a link that stutters is not taken up; longer is a longer wait
  double engaging_s = 1.0;         // as the filter's start ramp
  double degraded_age_s = 0.010;   // as the filter's hold
  double brake_age_s = 0.060;      // as the filter's end of all force
  double clutch_s = 0.5;           // to close it, else back to kReady
  double max_speed_m_per_s = 1.5;  // beyond is a fault; as the filter's
  double stopped_m_per_s = 0.02;   // assumed: the drift of a hand that keeps still
};

// The states of one arm. Step is pure but for its own memory.
class SafetyStates {
 public:
  void Step(const SafetyTimes& times, const SafetyInputs& in);

  [[nodiscard]] SafetyState state() const { return state_; }
  [[nodiscard]] bool is_engaged() const { return state_ >= SafetyState::kEngaging && state_ <= SafetyState::kDegraded; }
  // From 0 to 1 over kEngaging.
  [[nodiscard]] double share() const { return is_engaged() ? share_ : 0.0; }
  // Of the loss of force that is not over yet, or of the latest one; kNone: there was none.
  [[nodiscard]] FaultCause first_cause() const { return first_cause_; }

 private:
  void Enter(SafetyState state);

  SafetyState state_ = SafetyState::kOff;
  FaultCause first_cause_ = FaultCause::kNone;
  double in_state_s_ = 0.0;
  double link_good_s_ = 0.0;
  double share_ = 0.0;
  bool was_let_go_ = true;
};

}  // namespace hug
