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
// Attach: both jaws have pressed on the same object for kPressTicks, each pushed outwards by it along the jaws' axis:
// fingertips that both stand on one face are no grip. While held, the object's contacts with the hand
// do not push: the spring stands for them.
// Detach: the opening is kOpenMargin_m wider than at the attachment, or a jaw has lost the object for kLostTicks. The
// spring is soft beside the jaws, so under load the object moves between them and leaves a jaw without being let go;
// therefore a jaw has lost it only when its gap is wider than the spring's deflection by kLostMargin_m, or when it is
// no longer reported at all and the jaws have opened.
class GraspKeeper {
 public:
  static constexpr int kPressTicks = 5;
  static constexpr int kLostTicks = 20;
  static constexpr double kOpenMargin_m = 0.003;
  static constexpr double kLostMargin_m = 0.0005;
  static constexpr double kReopenMargin_m = 0.001;

  // A jaw's contact with an object as seen this tick.
  struct JawContact {
    bool is_reported = false;  // a fresh contact set exists
    bool is_squeezed = false;  // pushed outwards along the jaws' axis
    double gap_m = 1e9;
  };
  enum class Change : std::uint8_t { kUnchanged, kAttached, kDetached };

  explicit GraspKeeper(BuiltWorld* built);

  // One call per holdable and tick. Opening is the role's; `p_W` the grip point to use if it is grasped now.
  Change Update(std::size_t holdable, const JawContact& left, const JawContact& right, double opening_m,
                const glm::dvec3& p_W);

  void ExchangeState(physics::Checkpoint* checkpoint);

  // kNone: nothing. Index into BuiltWorld::holdables.
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
