#include "nodes/physics_node/hands.hpp"

#include <algorithm>
#include <cmath>

#include "core/clock.hpp"
#include "nodes/physics_node/physics_node.hpp"
#include "scene/has_fingers.hpp"

namespace physics_node {
namespace {

// Bounds the estimated speed of the jaws, in case the opening jumps. Chosen: far above the fastest deliberate motion.
constexpr double kMaxOpeningSpeed_m_per_s = 1.0;

constexpr double kPalmBandwidth_rad_per_s = 25.0;  // 4 Hz, chosen: that of a light-weight arm

bool IsFinite(const core::HapticProxy& proxy) {
  const glm::dquat& q = proxy.X_WD.rotation;
  const double sum = q.w + q.x + q.y + q.z + glm::dot(proxy.X_WD.translation, glm::dvec3(1.0)) +
                     glm::dot(proxy.V_WD.linear_m_per_s, glm::dvec3(1.0)) +
                     glm::dot(proxy.V_WD.angular_rad_per_s, glm::dvec3(1.0)) + proxy.opening_m;
  for (const double angle_rad : proxy.finger_rad) {
    if (!std::isfinite(angle_rad)) return false;
  }
  return std::isfinite(sum) && std::abs(glm::dot(q, q) - 1.0) < 1e-3;
}

}  // namespace

Hands::Hands(const scene::Scenario& scenario)
    : scenario_(scenario), num_hands_(std::min<std::size_t>(scenario.devices.size(), kMaxRoles)) {
  for (std::size_t i = 0; i < num_hands_; ++i) {
    hands_[i].X_WD = hands_[i].X_WPalm = scenario.devices[i].X_WD_start;
    hands_[i].opening_m = scenario.devices[i].opening_start_m;
    has_fingers_[i] = scene::HasFingers(scenario, static_cast<int>(i));
  }
}

void Hands::Update(const Inputs& inputs, std::uint64_t tick) {
  for (const core::HapticProxy& proxy : inputs.proxies) {
    if (proxy.role_index < num_hands_ && proxy.header.sequence != 0 && IsFinite(proxy)) TakeProxy(proxy, tick);
  }
  are_all_silent_ = true;
  for (std::size_t i = 0; i < num_hands_; ++i) {
    Hand& hand = hands_[i];
    hand.is_silent = !hand.is_known || tick - hand.received_tick > PhysicsNode::kMaxAgeTicks;
    if (hand.is_silent) {
      hand.V_WD = {};
      hand.opening_speed_m_per_s = 0.0;
    } else {
      are_all_silent_ = false;
    }
  }
  FollowDevices();
}

// Fingers hang on the palm by hard joints, and what they hold on friction. A tracker's frames come sixty times a
// second, so its pose moves in steps, of v / 60 Hz; carried out in one tick each would fling both. A robot's hand is
// carried by an arm: the palm P follows D with the arm's bandwidth w, critically damped and with the velocity told in
// advance,
//   a_P = w^2 (p_D - p_P) + 2 w (v_D - v_P),
// and its rotation likewise. A steady motion then has no lag, and a step of 0.1 m/s / 60 Hz gives 0.1 g.
void Hands::FollowDevices() {
  constexpr double w = kPalmBandwidth_rad_per_s;
  for (std::size_t i = 0; i < num_hands_; ++i) {
    Hand& hand = hands_[i];
    const glm::dvec3 way_W = hand.X_WD.translation - hand.X_WPalm.translation;
    const glm::dvec3 turn_W = core::RotationVector(hand.X_WD.rotation * glm::conjugate(hand.X_WPalm.rotation));
    core::Twist& V = hand.V_WPalm;
    V.linear_m_per_s += core::kTick_s * (w * w * way_W + 2.0 * w * (hand.V_WD.linear_m_per_s - V.linear_m_per_s));
    V.angular_rad_per_s +=
        core::kTick_s * (w * w * turn_W + 2.0 * w * (hand.V_WD.angular_rad_per_s - V.angular_rad_per_s));
    hand.X_WPalm.translation += core::kTick_s * V.linear_m_per_s;
    hand.X_WPalm.rotation =
        glm::normalize(core::QuaternionFromRotationVector(core::kTick_s * V.angular_rad_per_s) * hand.X_WPalm.rotation);
  }
}

void Hands::TakeProxy(const core::HapticProxy& proxy, std::uint64_t tick) {
  Hand& hand = hands_[proxy.role_index];
  if (hand.is_known && proxy.header.sequence == hand.sequence) return;
  // The message has no rate of the opening, so it is estimated by a backward difference; cycles are 1 ms apart.
  hand.opening_speed_m_per_s = 0.0;
  if (hand.is_known && proxy.cycle > hand.cycle && proxy.cycle - hand.cycle <= PhysicsNode::kMaxAgeTicks) {
    const double speed =
        (proxy.opening_m - hand.opening_m) / (static_cast<double>(proxy.cycle - hand.cycle) * core::kTick_s);
    hand.opening_speed_m_per_s = std::clamp(speed, -kMaxOpeningSpeed_m_per_s, kMaxOpeningSpeed_m_per_s);
  }
  hand.is_known = true;
  hand.sequence = proxy.header.sequence;
  hand.cycle = proxy.cycle;
  hand.received_tick = tick;
  hand.X_WD = {glm::normalize(proxy.X_WD.rotation), proxy.X_WD.translation};
  hand.V_WD = proxy.V_WD;
  hand.opening_m = proxy.opening_m;
  if (!proxy.finger_rad.empty()) hand.finger_rad = proxy.finger_rad;
  hand.direct = proxy.header.direct;
  newest_cycle_ = proxy.cycle;  // a restarted haptic_node counts from 1 again: the newest, not the largest
}

void Hands::Place(BuiltWorld* built) const {
  for (std::size_t i = 0; i < scenario_.objects.size(); ++i) {
    const scene::Object& object = scenario_.objects[i];
    if (object.owner != scene::Owner::kHand || object.role < 0 || object.role >= static_cast<int>(kMaxRoles)) continue;
    const Hand& hand = hands_[static_cast<std::size_t>(object.role)];
    const bool has_fingers = has_fingers_[static_cast<std::size_t>(object.role)];
    const core::Pose& X_WH = has_fingers ? hand.X_WPalm : hand.X_WD;
    const core::Twist& V_WH = has_fingers ? hand.V_WPalm : hand.V_WD;
    const core::Pose X_WPart = scene::PartPose(object.part, X_WH, hand.opening_m);
    core::Twist V_WPart{V_WH.angular_rad_per_s, core::PointVelocity(V_WH, X_WPart.translation - X_WH.translation)};
    const double side = object.part == scene::HandPart::kJawLeft    ? -0.5
                        : object.part == scene::HandPart::kJawRight ? 0.5
                                                                    : 0.0;
    V_WPart.linear_m_per_s += hand.X_WD.rotate({side * hand.opening_speed_m_per_s, 0.0, 0.0});
    built->world->SetKinematic(built->body_of_object[i], X_WPart, V_WPart);
  }
  for (std::size_t i = 0; i < scenario_.mechanisms.size(); ++i) {
    const scene::Mechanism& m = scenario_.mechanisms[i];
    if (m.finger_role < 0 || m.finger_role >= static_cast<int>(kMaxRoles)) continue;
    const auto& finger_rad = hands_[static_cast<std::size_t>(m.finger_role)].finger_rad;
    const auto joint = static_cast<std::size_t>(m.finger_joint);
    if (joint < finger_rad.size()) built->hinges[i]->SetServoTarget(finger_rad[joint]);
  }
}

void Hands::ExchangeState(physics::Checkpoint* checkpoint) {
  checkpoint->Exchange(&newest_cycle_);
  checkpoint->Exchange(&are_all_silent_);
  checkpoint->Exchange(&hands_);
}

}  // namespace physics_node
