#include "nodes/device_bridge/operator/pointer_hand.hpp"

#include <algorithm>
#include <cmath>

namespace device_bridge {
namespace {

// Viewers send some thirty times a second: the target follows what is wanted with this time constant, so that the hand
// does not feel their steps.
constexpr double kFollow_s = 0.03;
constexpr double kFastest_m_per_s = 0.6;
constexpr double kFastest_rad_per_s = 3.0;
// Of a hand that is led; it holds back what is faster.
constexpr double kRelax_s = 0.2;
constexpr double kGivesWay_m_per_s = 0.3;
constexpr double kGivesWay_rad_per_s = 1.0;
constexpr double kGripSpeed_m_per_s = 0.15;  // as the scripted operator's
constexpr double kGripStrength_N = 30.0;
constexpr double kPushShare = 0.85;                      // of the force limit, as the scripted operator's
constexpr double kLongestTurn_rad = 0.35;                // of the target before the hand, the same
constexpr std::int64_t kViewerSilence_ns = 300'000'000;  // a viewer that says nothing for this long has let go

glm::dvec3 Within(const glm::dvec3& v, double limit) {
  const double length = glm::length(v);
  return length > limit ? (limit / length) * v : v;
}

bool IsUsableWay(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace

PointerHand::PointerHand(const scene::Scenario& scenario) {
  for (const scene::Device& device : scenario.devices) {
    Hand hand;
    hand.X_WWanted = device.X_WD_start;
    hand.opening_max_m = device.opening_max_m;
    hand.opening_wanted_m = device.opening_start_m;
    const double force_limit_N = kPushShare * std::min(device.max_force_N, scenario.force_cap_N);
    hand.longest_lead_m = force_limit_N / std::max(1.0, device.hand_stiffness_N_per_m);
    hand.target.X_WT = hand.X_WD_before = device.X_WD_start;
    hand.target.opening_m = device.opening_start_m;
    hand.target.grip_strength_N = kGripStrength_N;
    hands_.push_back(hand);
  }
}

void PointerHand::TakeUp(std::size_t role, const HandTarget& target) noexcept {
  Hand& hand = hands_[role];
  hand.X_WWanted = target.X_WT;
  hand.opening_wanted_m = target.opening_m;
  hand.target = target;
  hand.target.V_WT = {};
}

void PointerHand::Take(const core::HandInput& input, Viewer* viewer, std::int64_t now_ns) noexcept {
  if (input.header.sequence == viewer->sequence || input.role_index >= hands_.size()) return;
  if (!IsUsableWay(input.moved_W_m) || !IsUsableWay(input.turned_W_rad) || !std::isfinite(input.closing)) return;
  const bool was_started_again = input.header.sequence < viewer->sequence;
  const bool is_first = viewer->sequence == 0 || was_started_again;
  Hand& hand = hands_[input.role_index];
  // What was moved while the clutch was open does not count.
  if (!is_first && viewer->is_held && input.is_held) {
    hand.X_WWanted.translation += input.moved_W_m - viewer->moved_W_m;
    hand.X_WWanted.rotation = glm::normalize(
        core::QuaternionFromRotationVector(input.turned_W_rad - viewer->turned_W_rad) * hand.X_WWanted.rotation);
  }
  if (!is_first && input.closing != viewer->closing) {
    hand.opening_wanted_m = (1.0 - std::clamp(input.closing, 0.0, 1.0)) * hand.opening_max_m;
  }
  *viewer = {input.header.sequence, input.is_held, input.moved_W_m, input.turned_W_rad, input.closing, now_ns};
  wants_guidance_ = input.wants_guidance;
}

// What is wanted and the target move as the device has since the latest tick, and what is wanted comes back to it.
void PointerHand::GiveWay(const DeviceReading& reading, double dt_s, Hand* hand) noexcept {
  const glm::dvec3 moved_W = reading.X_WD.translation - hand->X_WD_before.translation;
  const glm::dquat turned_W = reading.X_WD.rotation * glm::conjugate(hand->X_WD_before.rotation);
  for (core::Pose* X : {&hand->X_WWanted, &hand->target.X_WT}) {
    *X = {glm::normalize(turned_W * X->rotation), X->translation + moved_W};
  }
  const double share = std::min(1.0, dt_s / kRelax_s);
  core::Pose& wanted = hand->X_WWanted;
  wanted.translation += share * (reading.X_WD.translation - wanted.translation);
  const glm::dvec3 turn_W = core::RotationVector(reading.X_WD.rotation * glm::conjugate(wanted.rotation));
  wanted.rotation = glm::normalize(core::QuaternionFromRotationVector(share * turn_W) * wanted.rotation);
}

// With the lead l of what is wanted before the target, v = l / tau, within the speeds above; and what is wanted never
// runs further before the hand than the spring may push.
void PointerHand::Follow(const DeviceReading& reading, bool is_off, double dt_s, Hand* hand) noexcept {
  HandTarget& target = hand->target;
  if (hand->is_led) GiveWay(reading, dt_s, hand);
  if (is_off) hand->X_WWanted = target.X_WT = reading.X_WD;  // nobody presses against a device without force
  hand->X_WWanted.translation =
      reading.X_WD.translation + Within(hand->X_WWanted.translation - reading.X_WD.translation, hand->longest_lead_m);
  const glm::dvec3 turn_W = core::RotationVector(hand->X_WWanted.rotation * glm::conjugate(reading.X_WD.rotation));
  hand->X_WWanted.rotation =
      glm::normalize(core::QuaternionFromRotationVector(Within(turn_W, kLongestTurn_rad)) * reading.X_WD.rotation);
  target.V_WT.linear_m_per_s =
      Within((hand->X_WWanted.translation - target.X_WT.translation) / kFollow_s, kFastest_m_per_s);
  target.V_WT.angular_rad_per_s =
      Within(core::RotationVector(hand->X_WWanted.rotation * glm::conjugate(target.X_WT.rotation)) / kFollow_s,
             kFastest_rad_per_s);
  target.X_WT.translation += dt_s * target.V_WT.linear_m_per_s;
  target.X_WT.rotation =
      glm::normalize(core::QuaternionFromRotationVector(dt_s * target.V_WT.angular_rad_per_s) * target.X_WT.rotation);
  if (hand->is_led) {  // the target goes on with the device, too, or its damper would hold the device back
    target.V_WT.linear_m_per_s += Within(reading.V_WD.linear_m_per_s, kGivesWay_m_per_s);
    target.V_WT.angular_rad_per_s += Within(reading.V_WD.angular_rad_per_s, kGivesWay_rad_per_s);
  }
  hand->X_WD_before = reading.X_WD;
  const double way_m = hand->opening_wanted_m - target.opening_m;
  const double step_m = std::clamp(way_m, -kGripSpeed_m_per_s * dt_s, kGripSpeed_m_per_s * dt_s);
  target.opening_m += step_m;
  target.opening_velocity_m_per_s = dt_s > 0.0 ? step_m / dt_s : 0.0;
}

void PointerHand::Step(const Inputs& inputs, const core::FixedVector<FeltForce, kMaxRoles>& felt,
                       const core::FixedVector<DeviceReading, kMaxRoles>& readings, double dt_s) noexcept {
  for (std::size_t i = 0; i < inputs.hands.size(); ++i) Take(inputs.hands[i], &viewers_[i], inputs.now_ns);
  bool is_anybody_there = false;
  for (Viewer& viewer : viewers_) {
    if (inputs.now_ns - viewer.heard_ns > kViewerSilence_ns) viewer.is_held = false;
    is_anybody_there = is_anybody_there || inputs.now_ns - viewer.heard_ns <= kViewerSilence_ns;
  }
  wants_guidance_ = wants_guidance_ && is_anybody_there;
  for (std::size_t role = 0; role < hands_.size() && role < readings.size(); ++role) {
    Follow(readings[role], felt[role].is_off, dt_s, &hands_[role]);
  }
}

}  // namespace device_bridge
