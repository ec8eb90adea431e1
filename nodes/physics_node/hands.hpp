#pragma once

#include <array>
#include <cstdint>

#include "nodes/physics_node/build_world.hpp"
#include "nodes/physics_node/ports.hpp"
#include "physics/checkpoint.hpp"
#include "scene/scenario.hpp"

namespace physics_node {

// State of one hand.
struct Hand {
  std::uint64_t sequence = 0;  // of the newest proxy
  std::uint64_t cycle = 0;
  std::uint64_t received_tick = 0;
  bool is_known = false;
  bool is_silent = true;  // no message for PhysicsNode::kMaxAgeTicks
  core::Pose X_WD;
  core::Twist V_WD;
  core::Pose X_WPalm;  // of a hand with fingers: follows D (Hands::FollowDevices)
  core::Twist V_WPalm;
  double opening_m = 0.0;
  double opening_speed_m_per_s = 0.0;
  core::FixedVector<double, core::kMaxFingerJoints> finger_rad;  // empty: not told yet
  core::Trace direct;
};

// The hands, one per device, from the messages of haptic_node; their parts are kinematic bodies of the world.
class Hands {
 public:
  explicit Hands(const scene::Scenario& scenario);

  // Applies messages that are new and finite; sets the velocity of silent hands to zero.
  void Update(const Inputs& inputs, std::uint64_t tick);
  // Sets pose and velocity of every body that is a part of a hand, and where the servos of its fingers turn.
  void Place(BuiltWorld* built) const;

  [[nodiscard]] const Hand& operator[](std::size_t role) const { return hands_[role]; }
  // Haptic cycle of the newest message about any hand.
  [[nodiscard]] std::uint64_t newest_cycle() const { return newest_cycle_; }
  [[nodiscard]] bool are_all_silent() const { return are_all_silent_; }

  void ExchangeState(physics::Checkpoint* checkpoint);

 private:
  void FollowDevices();
  void TakeProxy(const core::HapticProxy& proxy, std::uint64_t tick);

  const scene::Scenario& scenario_;
  std::size_t num_hands_ = 0;
  std::array<bool, kMaxRoles> has_fingers_{};
  std::array<Hand, kMaxRoles> hands_;
  std::uint64_t newest_cycle_ = 0;
  bool are_all_silent_ = true;
};

}  // namespace physics_node
