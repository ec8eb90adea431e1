#include "nodes/device_bridge/operator/simulated_operator.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/clock.hpp"

namespace device_bridge {
namespace {

// Behaviour of the operator. No study selected these values; they are plausible for a person, and the procedures of
// scenarios/ succeed with them (tests/acceptance). Shorter times and larger leads make it faster and less careful.
// Above what friction asks for: the upper end of what was measured of people. The other two are free choices, not
// measured: a light touch, and from 25 N to that in two seconds.
constexpr double kGripMargin = 1.4;
constexpr double kLeastGrip_N = 2.0;
constexpr double kEaseOff_N_per_s = 12.0;
constexpr double kTwoPi = 6.283185307179586;
constexpr double kShortestStroke_s = 0.2;
constexpr double kWithin_s = 0.1;              // the seen error must stay within the tolerance for this long
constexpr double kStillSpeed_m_per_s = 0.015;  // below this seen speed the hand counts as at rest
constexpr double kMaxObservation_s = 0.6;      // after this time a correction starts even if the hand is not at rest
constexpr double kMaxLead_m = 0.03;            // of the target ahead of the seen hand when it is blocked
constexpr double kMaxTurnLead_rad = 0.35;
constexpr double kSearchRadius_m = 0.0015;  // of the order of the scenarios' clearances and lateral tolerances
constexpr double kSearch_Hz = 1.0;
constexpr double kSearchGrowth_s = 3.0;  // from the centre to the full radius, then again from the centre
constexpr double kStall_s = 0.5;  // stalled: progress below kStallProgress_m for this time, against kStallForce_N
constexpr double kStallProgress_m = 0.0005;
constexpr double kStallForce_N = 2.0;
constexpr double kPushRise_s = 0.2;            // of the speed of a push
constexpr double kPushBraking_m_per_s2 = 0.5;  // deceleration before the end of its distance
constexpr double kMaxSearch_s = 8.0;           // after the whole distance was pushed
constexpr double kMaxPushShare = 0.85;         // of the force limit; the operator pushes no further above it
constexpr double kRetryDelay_s = 4.0;          // after the last line of a step that does not end
constexpr std::size_t kMaxRecords = 4096;

glm::dvec3 Shortened(const glm::dvec3& v, double limit) {
  const double length = glm::length(v);
  return length > limit ? (limit / length) * v : v;
}

}  // namespace

SimulatedOperator::SimulatedOperator(const scene::Scenario& scenario, OperatorScript script, std::uint64_t seed,
                                     const OperatorOptions& options)
    : script_(std::move(script)), options_(options), random_(seed), sight_(scenario, options.visual_delay_s) {
  end_point_error_ = random_.Uniform(0.05, 0.08);
  if (options.end_point_error >= 0.0) end_point_error_ = options.end_point_error;
  records_.reserve(kMaxRecords);
  hands_.reserve(scenario.devices.size());
  for (const scene::Device& device : scenario.devices) {
    Hand hand(options.reaction_s);
    hand.X_WB = device.X_WD_start;
    hand.opening_from_m = device.opening_start_m;
    hand.stiffness_N_per_m = std::max(1.0, device.hand_stiffness_N_per_m);
    hand.force_limit_N = kMaxPushShare * std::min(device.max_force_N, scenario.force_cap_N);
    for (int i = 0; i < 3; ++i) {
      hand.tremor_hz[i] = random_.Uniform(8.0, 12.0);
      hand.tremor_phase_rad[i] = random_.Uniform(0.0, kTwoPi);
    }
    hand.target.X_WT = device.X_WD_start;
    hand.target.opening_m = device.opening_start_m;
    hands_.push_back(std::move(hand));
  }
}

void SimulatedOperator::Watch(const Inputs& inputs, const core::FixedVector<FeltForce, kMaxRoles>& felt,
                              const core::FixedVector<DeviceReading, kMaxRoles>& readings) noexcept {
  last_ns_ = inputs.now_ns;
  has_started_ = true;
  sight_.Record(inputs, readings, StepIndexOf(script_, inputs.logic));
  for (std::size_t role = 0; role < hands_.size() && role < felt.size(); ++role) {
    hands_[role].touch.Record(inputs.now_ns, felt[role]);
  }
}

void SimulatedOperator::TakeUp(std::size_t role, const HandTarget& target) noexcept {
  if (current_ != nullptr) EndLine(LineOutcome::kAbandoned, last_ns_);
  step_ = -1;
  Hand& hand = hands_[role];
  hand.X_WB = target.X_WT;
  hand.V_WB = core::Twist{};
  hand.stroke = Stroke();
  hand.opening_duration_s = 0.0;
  hand.grip_strength_N = hand.strongest_grip_N = target.grip_strength_N;
  hand.grip_friction = 0.0;
  hand.target = target;
}

void SimulatedOperator::Step(const Inputs& inputs, const core::FixedVector<FeltForce, kMaxRoles>& felt,
                             const core::FixedVector<DeviceReading, kMaxRoles>& readings) noexcept {
  const std::int64_t now_ns = inputs.now_ns;
  const double dt_s =
      has_started_ ? std::clamp(static_cast<double>(now_ns - last_ns_) * 1e-9, 0.0, 0.01) : core::kTick_s;
  time_s_ += dt_s;
  Watch(inputs, felt, readings);

  const Sighting* seen = sight_.At(now_ns);
  FollowStep(seen, now_ns);
  bool waits = false;
  for (Hand& hand : hands_) {
    const FeltForce felt_then = hand.touch.At(now_ns);
    if (felt_then.is_off && !hand.is_relaxed) RelaxHand(&hand, felt_then);
    hand.is_relaxed = felt_then.is_off;
    waits = waits || felt_then.is_off;
  }
  if (seen != nullptr && current_ != nullptr && !waits) CarryOutLine(*seen, now_ns, dt_s);
  for (Hand& hand : hands_) UpdateTarget(&hand, dt_s);
}

void SimulatedOperator::FollowStep(const Sighting* seen, std::int64_t now_ns) noexcept {
  const int step = seen == nullptr ? -1 : seen->step;
  if (step != step_) {
    if (current_ != nullptr) Abandon(now_ns);
    step_ = step;
    next_line_ = 0;
  }
  if (current_ != nullptr || step_ < 0) return;
  const std::vector<OperatorLine>& lines = script_.steps[static_cast<std::size_t>(step_)].lines;
  if (next_line_ >= lines.size()) {
    // All lines are done but the step goes on, e.g. because a node was away meanwhile: start again.
    if (lines.empty() || static_cast<double>(now_ns - record_.end_ns) * 1e-9 < kRetryDelay_s) return;
    next_line_ = 0;
  }
  current_ = &lines[next_line_++];
  record_ = {step_, current_->line, now_ns, now_ns, 0, LineOutcome::kDone};
  line_s_ = 0.0;
  is_line_over_ = false;
  outcome_ = LineOutcome::kDone;
  EnterPhase(Phase::kBegin);
}

// A push is relaxed first, else its target would stay beyond the hand and press on during the lines that follow.
void SimulatedOperator::Abandon(std::int64_t now_ns) noexcept {
  const bool is_push = current_->verb == Verb::kPush;
  if (is_push && phase_ == Phase::kRelax) return;  // its relaxation ends by itself
  if (is_push && phase_ == Phase::kPush) {
    EndPush(*current_, hands_[static_cast<std::size_t>(current_->role)].touch.At(now_ns));
    outcome_ = LineOutcome::kAbandoned;
    return;
  }
  EndLine(LineOutcome::kAbandoned, now_ns);
}

void SimulatedOperator::EnterPhase(Phase phase) noexcept {
  phase_ = phase;
  phase_s_ = 0.0;
}

void SimulatedOperator::EndLine(LineOutcome outcome, std::int64_t now_ns) noexcept {
  Hand& hand = hands_[static_cast<std::size_t>(current_->role)];
  hand.stroke = Stroke();
  hand.V_WB = core::Twist{};
  record_.end_ns = now_ns;
  record_.outcome = outcome;
  if (records_.size() < kMaxRecords) records_.push_back(record_);
  current_ = nullptr;
  is_searching_ = false;
}

// Without resistance a person stops pressing: moves the target back by F / K to the hand's pose (see EndPush).
void SimulatedOperator::RelaxHand(Hand* hand, const FeltForce& felt) noexcept {
  const glm::dvec3 lead_W = felt.hand_F_Do_W.force_N / hand->stiffness_N_per_m;
  hand->V_WB = core::Twist{};
  hand->stroke = Stroke(hand->X_WB, -lead_W, glm::dvec3(0.0), 0.1);
  const bool is_pushing = current_ != nullptr && current_->verb == Verb::kPush && phase_ == Phase::kPush &&
                          hand == &hands_[static_cast<std::size_t>(current_->role)];
  if (is_pushing) pushed_m_ -= std::clamp(glm::dot(lead_W, current_->direction_W), 0.0, pushed_m_);
}

void SimulatedOperator::CarryOutLine(const Sighting& seen, std::int64_t now_ns, double dt_s) noexcept {
  const OperatorLine& line = *current_;
  Hand& hand = hands_[static_cast<std::size_t>(line.role)];
  const FeltForce felt = hand.touch.At(now_ns);
  const core::Pose& X_WHand = seen.X_WHand[static_cast<std::size_t>(line.role)];
  if (seen.time_ns > seen_before_ns_) {
    const double seen_dt_s = static_cast<double>(seen.time_ns - seen_before_ns_) * 1e-9;
    const double speed = glm::length(X_WHand.translation - X_WHand_before_.translation) / seen_dt_s;
    // First-order low-pass of 20 ms, as vision does not resolve single milliseconds. Assumed.
    seen_speed_m_per_s_ += std::min(1.0, seen_dt_s / 0.02) * (speed - seen_speed_m_per_s_);
    X_WHand_before_ = X_WHand;
    seen_before_ns_ = seen.time_ns;
  }
  switch (line.verb) {
    case Verb::kReach:
    case Verb::kCarry:
      Move(line, seen, dt_s);
      break;
    case Verb::kPush:
      Push(line, seen, felt, dt_s);
      break;
    case Verb::kGrip:
      Grip(line, felt, dt_s);
      break;
    case Verb::kWait:
      if (line.until.kind != ConditionKind::kNone) {
        is_line_over_ = IsSatisfied(line.until, seen, line.role);
      } else {
        is_line_over_ = line_s_ >= line.seconds;
      }
      break;
  }
  phase_s_ += dt_s;
  line_s_ += dt_s;
  if (is_searching_) search_s_ += dt_s;
  if (is_line_over_) EndLine(outcome_, now_ns);
}

void SimulatedOperator::BeginStroke(const OperatorLine& line, const Aim& aim, bool is_first) noexcept {
  Hand& hand = hands_[static_cast<std::size_t>(line.role)];
  // The first stroke moves the target to the goal. A correction adds the seen error to the target instead, so it also
  // compensates a steady offset between target and hand (a load, a contact); its lead over the hand is limited, in case
  // the hand is blocked.
  glm::dvec3 way_W = aim.way_W;
  glm::dvec3 turn_W = aim.turn_W;
  if (is_first) {
    way_W = aim.X_WHand.translation + aim.way_W - hand.X_WB.translation;
    turn_W = core::RotationVector(core::QuaternionFromRotationVector(aim.turn_W) * aim.X_WHand.rotation *
                                  glm::conjugate(hand.X_WB.rotation));
  } else {
    const glm::dvec3 lead_W = hand.X_WB.translation + way_W - aim.X_WHand.translation;
    const double longest_m = std::max(kMaxLead_m, glm::length(aim.way_W));
    way_W = aim.X_WHand.translation + Shortened(lead_W, longest_m) - hand.X_WB.translation;
    const glm::dvec3 turn_lead_W = core::RotationVector(core::QuaternionFromRotationVector(turn_W) *
                                                        hand.X_WB.rotation * glm::conjugate(aim.X_WHand.rotation));
    const double widest_rad = std::max(kMaxTurnLead_rad, glm::length(aim.turn_W));
    turn_W = core::RotationVector(core::QuaternionFromRotationVector(Shortened(turn_lead_W, widest_rad)) *
                                  aim.X_WHand.rotation * glm::conjugate(hand.X_WB.rotation));
  }
  way_W += random_.GaussianVector(end_point_error_ * glm::length(way_W));
  turn_W += random_.GaussianVector(end_point_error_ * glm::length(turn_W));
  const double duration_s = std::max({kShortestStroke_s, StrokeDuration(glm::length(way_W), line.speed_m_per_s),
                                      StrokeDuration(glm::length(turn_W), options_.turn_speed_rad_per_s)});
  hand.stroke = Stroke(hand.X_WB, way_W, turn_W, duration_s);
  ++record_.num_strokes;
  EnterPhase(Phase::kStroke);
}

void SimulatedOperator::Move(const OperatorLine& line, const Sighting& seen, double dt_s) noexcept {
  Hand& hand = hands_[static_cast<std::size_t>(line.role)];
  const Aim aim = ComputeAim(line, seen);
  if (!aim.is_valid) return;  // waits until both frames are visible
  if (phase_ == Phase::kBegin) {
    within_s_ = 0.0;
    num_in_vain_ = 0;
    best_error_m_ = 1e9;
    BeginStroke(line, aim, true);
    return;
  }
  if (phase_ == Phase::kStroke && hand.stroke.is_over()) EnterPhase(Phase::kObserve);
  if (phase_ != Phase::kObserve) return;

  const double error_m = std::max(aim.distance_m, kLever_m * aim.angle_rad);
  const bool is_still = seen_speed_m_per_s_ < kStillSpeed_m_per_s;
  within_s_ = error_m <= line.within_m && is_still ? within_s_ + dt_s : 0.0;
  if (within_s_ >= kWithin_s) {
    is_line_over_ = true;
    return;
  }
  if (within_s_ > 0.0) return;
  // The seen scene must show the end of the last stroke, else the correction would be made twice.
  if (phase_s_ < options_.visual_delay_s + 0.05 || (!is_still && phase_s_ < kMaxObservation_s)) return;
  if (line.verb == Verb::kCarry) {
    num_in_vain_ = error_m > 0.85 * best_error_m_ ? num_in_vain_ + 1 : 0;
    const bool is_blocked = glm::length(hand.touch.At(last_ns_).F_Do_W.force_N) > kStallForce_N;
    if (num_in_vain_ >= 2 && is_blocked && !is_searching_) {
      is_searching_ = true;
      search_s_ = 0.0;
      search_normal_W_ = aim.distance_m > 1e-6 ? glm::normalize(aim.way_W) : glm::dvec3(0, 0, 1);
    }
    if (num_in_vain_ == 0) is_searching_ = false;
  }
  best_error_m_ = std::min(best_error_m_, error_m);
  BeginStroke(line, aim, false);
}

void SimulatedOperator::Push(const OperatorLine& line, const Sighting& seen, const FeltForce& felt,
                             double dt_s) noexcept {
  Hand& hand = hands_[static_cast<std::size_t>(line.role)];
  const core::Pose& X_WHand = seen.X_WHand[static_cast<std::size_t>(line.role)];
  if (phase_ == Phase::kRelax) {
    is_line_over_ = hand.stroke.is_over();
    return;
  }
  if (phase_ == Phase::kBegin) {
    EnterPhase(Phase::kPush);
    pushed_m_ = push_time_s_ = stalled_s_ = used_up_s_ = 0.0;
    progress_m_ = 0.0;
    p_push_begin_ = X_WHand.translation;
    hand.stroke = Stroke();
  }
  const double resistance_N = -glm::dot(felt.F_Do_W.force_N, line.direction_W);

  if (line.until_felt_N > 0.0 && resistance_N >= line.until_felt_N) return EndPush(line, felt);
  if (IsSatisfied(line.until, seen, line.role)) return EndPush(line, felt);

  // Speed: a minimum-jerk rise to v, braking v = sqrt(2 a d) over the remaining distance d, zero above the force limit.
  push_time_s_ += dt_s;
  const double remaining_m = line.distance_m - pushed_m_;
  double speed = line.speed_m_per_s * MinimumJerk(push_time_s_ / kPushRise_s);
  speed = std::min(speed, std::sqrt(2.0 * kPushBraking_m_per_s2 * std::max(0.0, remaining_m)));
  if (resistance_N > hand.force_limit_N) speed = 0.0;
  const double way_m = std::min(speed * dt_s, remaining_m);
  pushed_m_ += way_m;
  hand.X_WB.translation += way_m * line.direction_W;
  hand.V_WB.linear_m_per_s = speed * line.direction_W;

  // Stalled before the condition is satisfied: search.
  const double progress_m = glm::dot(X_WHand.translation - p_push_begin_, line.direction_W);
  const bool has_moved = progress_m > progress_m_ + kStallProgress_m;
  stalled_s_ = has_moved ? 0.0 : stalled_s_ + dt_s;
  if (has_moved) progress_m_ = progress_m;
  const bool is_stuck = stalled_s_ > kStall_s && resistance_N > kStallForce_N;
  if (line.until.kind != ConditionKind::kNone && is_stuck && !is_searching_) {
    is_searching_ = true;
    search_s_ = 0.0;
    search_normal_W_ = line.direction_W;
  }

  if (remaining_m - way_m > 1e-6) return;
  // The whole distance was pushed; its effect is seen and felt only after the delays.
  hand.V_WB = core::Twist{};
  used_up_s_ += dt_s;
  const bool has_condition = line.until_felt_N > 0.0 || line.until.kind != ConditionKind::kNone;
  const double patience_s = !has_condition  ? 0.0
                            : is_searching_ ? kMaxSearch_s
                                            : options_.visual_delay_s + options_.reaction_s + kStall_s;
  if (used_up_s_ < patience_s) return;
  if (has_condition) outcome_ = LineOutcome::kDistanceUsedUp;
  is_line_over_ = true;
}

// Moves the target back to the hand's pose, so that the pressing force does not persist. Vision is too slow to see that
// pose, but the hand is F / K behind its target (K: the hand's stiffness), and F is felt.
void SimulatedOperator::EndPush(const OperatorLine& line, const FeltForce& felt) noexcept {
  Hand& hand = hands_[static_cast<std::size_t>(line.role)];
  is_searching_ = false;
  hand.V_WB = core::Twist{};
  const double own_N = std::max(0.0, glm::dot(felt.hand_F_Do_W.force_N, line.direction_W));
  const double back_m = std::min(own_N / hand.stiffness_N_per_m, pushed_m_);
  hand.stroke = Stroke(hand.X_WB, -back_m * line.direction_W, glm::dvec3(0.0), 0.1);
  EnterPhase(Phase::kRelax);
}

void SimulatedOperator::Grip(const OperatorLine& line, const FeltForce& felt, double dt_s) noexcept {
  Hand& hand = hands_[static_cast<std::size_t>(line.role)];
  if (phase_ == Phase::kBegin) {
    hand.opening_from_m = hand.target.opening_m;
    hand.opening_way_m = line.opening_m - hand.opening_from_m;
    hand.opening_duration_s =
        std::max(kShortestStroke_s, StrokeDuration(std::abs(hand.opening_way_m), options_.opening_speed_m_per_s));
    hand.opening_elapsed_s = 0.0;
    hand.grip_strength_N = hand.strongest_grip_N = line.grip_strength_N;
    hand.grip_friction = line.grip_friction;
    progress_m_ = felt.opening_m;
    within_s_ = 0.0;
    EnterPhase(Phase::kGrip);
    return;
  }
  if (hand.opening_elapsed_s < hand.opening_duration_s) return;
  // Settled: the opening has not changed by 0.2 mm for kWithin_s, on the object or at the given opening.
  within_s_ = std::abs(felt.opening_m - progress_m_) < 2e-4 ? within_s_ + dt_s : 0.0;
  if (within_s_ == 0.0) progress_m_ = felt.opening_m;
  const bool has_settled = within_s_ >= kWithin_s;
  is_line_over_ = (has_settled && phase_s_ > hand.opening_duration_s + options_.reaction_s) || phase_s_ > 3.0;
}

void SimulatedOperator::UpdateTarget(Hand* hand, double dt_s) noexcept {
  if (!hand->stroke.is_over()) {
    hand->stroke.Advance(dt_s);
    hand->X_WB = hand->stroke.pose();
    hand->V_WB = hand->stroke.velocity();
  }
  hand->target.X_WT = hand->X_WB;
  hand->target.V_WT = hand->V_WB;

  // Physiological tremor: one sine of 8 to 12 Hz per axis.
  const double amplitude_m = options_.tremor_m / std::sqrt(3.0);
  for (int i = 0; i < 3; ++i) {
    const double omega = kTwoPi * hand->tremor_hz[i];
    const double angle = omega * time_s_ + hand->tremor_phase_rad[i];
    hand->target.X_WT.translation[i] += amplitude_m * std::sin(angle);
    hand->target.V_WT.linear_m_per_s[i] += amplitude_m * omega * std::cos(angle);
  }

  // Search: the spiral r(t) (cos(2 pi f t) u + sin(2 pi f t) v) in the plane normal to the way, faded in and out in 0.2
  // s.
  const bool searches =
      is_searching_ && current_ != nullptr && hand == &hands_[static_cast<std::size_t>(current_->role)];
  hand->search_gain = std::clamp(hand->search_gain + (searches ? dt_s : -dt_s) / 0.2, 0.0, 1.0);
  if (hand->search_gain > 0.0) {
    const glm::dvec3 n = search_normal_W_;
    const glm::dvec3 helper = std::abs(n.x) < 0.7 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 u = glm::normalize(glm::cross(n, helper));
    const glm::dvec3 v = glm::cross(n, u);
    const double turns = kSearch_Hz * search_s_;
    const double radius_m = hand->search_gain * kSearchRadius_m * std::fmod(search_s_ / kSearchGrowth_s, 1.0);
    hand->target.X_WT.translation += radius_m * (std::cos(kTwoPi * turns) * u + std::sin(kTwoPi * turns) * v);
  }

  // Jaws.
  const double before = hand->opening_elapsed_s;
  if (hand->opening_duration_s > 0.0 && before < hand->opening_duration_s) {
    hand->opening_elapsed_s += dt_s;
    const double u = hand->opening_elapsed_s / hand->opening_duration_s;
    hand->target.opening_m = hand->opening_from_m + hand->opening_way_m * MinimumJerk(u);
    hand->target.opening_velocity_m_per_s = hand->opening_way_m * MinimumJerkRate(u) / hand->opening_duration_s;
  } else {
    hand->target.opening_velocity_m_per_s = 0.0;
  }
  FollowLoad(hand, dt_s);
  hand->target.grip_strength_N = hand->grip_strength_N;
}

// Two fingers that press with N hold a load L = 2 mu N. A person presses with some more than that, follows a load that
// grows, and eases off slowly [Johansson and Westling 1984: margins of 10 to 40 %, and the grip follows the load]:
//   N = m L / (2 mu),   not below N - r dt.
void SimulatedOperator::FollowLoad(Hand* hand, double dt_s) const noexcept {
  if (hand->grip_friction == 0.0) return;
  const double load_N = glm::length(hand->touch.At(last_ns_).F_Do_W.force_N);
  const double needed_N = kGripMargin * load_N / (2.0 * hand->grip_friction);
  const double eased_N = hand->grip_strength_N - kEaseOff_N_per_s * dt_s;
  hand->grip_strength_N = std::clamp(std::max(needed_N, eased_N), kLeastGrip_N, hand->strongest_grip_N);
}

}  // namespace device_bridge
