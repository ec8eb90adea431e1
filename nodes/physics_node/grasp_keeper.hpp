#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/messages/haptic.hpp"
#include "nodes/physics_node/build_world.hpp"
#include "nodes/physics_node/ports.hpp"

namespace physics_node {

// Decides, once per tick, which object each gripper holds (architecture section 1: a grasp is a 6-DoF spring-damper
// between gripper and object, enabled while both jaws press on it).
//
// Attach: both jaws have pressed on the object for kPressTicks, and it pushes each of them outwards along the jaws'
// axis, so fingertips on one face do not grasp. While held, the object's contacts with the hand exert no force; the
// spring replaces them.
//
// Detach: the opening exceeds that at the attachment by kOpenMargin_m, or a jaw has lost the object for kLostTicks. The
// spring is softer than the jaws, so under load the object moves between them and may leave a jaw while it is held.
// Therefore a jaw has lost the object only if gap > |deflection of the spring| + kLostMargin_m, or, without a reported
// contact, if the opening exceeds that at the attachment by kReopenMargin_m.
//
// Free choices within wide bounds: with 1 or 100 ticks of pressing, 1 tick of loss, an opening margin of 0.5 or 10 mm,
// no lost margin, or a reopen margin of 0.1 mm, module_replacement in lock-step grasps and lets go as often, at most
// 0.2 s later. They trade a grasp at a brush against one that comes late (the operator's jaws close at 0.15 m/s, by
// 0.75 mm in 5 ms), and letting go at once against losing what is only late: 20 ticks are kMaxAgeTicks, after which a
// contact that did not come counts as none. Larger margins hold on while a hand opens, smaller ones lose what gives.
// Both waits are held by PhysicsNode.ABrushOfBothJawsDoesNotHold and PhysicsNode.AJawThatLosesItForAMomentKeepsIt.
class GraspKeeper {
 public:
  static constexpr int kPressTicks = 5;
  static constexpr int kLostTicks = 20;
  static constexpr double kOpenMargin_m = 0.003;
  static constexpr double kLostMargin_m = 0.0005;
  static constexpr double kReopenMargin_m = 0.001;

  // Contact of a jaw with an object in this tick.
  struct JawContact {
    bool is_reported = false;  // a fresh contact set exists
    bool is_squeezed = false;  // pushed outwards along the jaws' axis
    double gap_m = 1e9;
    bool is_loose = false;  // it holds by friction, and does not press
  };
  enum class Change : std::uint8_t { kUnchanged, kAttached, kDetached };

  explicit GraspKeeper(BuiltWorld* built);

  // One call per holdable and tick, with the role's opening and the grip point for an attachment in this tick.
  Change Update(std::size_t holdable, const JawContact& left, const JawContact& right, double opening_m,
                const glm::dvec3& p_W);

  void ExchangeState(physics::Checkpoint* checkpoint);

  // Index into BuiltWorld::holdables; kNone: nothing.
  [[nodiscard]] int held_by(std::size_t role) const { return held_[role]; }

 private:
  struct Watch {
    int press_ticks = 0;
    int lost_ticks = 0;
    double opening_m = 0.0;  // at the attachment
  };
  Change Attach(std::size_t holdable, double opening_m, const glm::dvec3& p_W);
  Change Detach(std::size_t holdable);

  BuiltWorld* built_;
  std::vector<Watch> watches_;
  std::array<int, kMaxRoles> held_{};
};

}  // namespace physics_node
