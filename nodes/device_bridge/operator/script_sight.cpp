#include "nodes/device_bridge/operator/script_sight.hpp"

namespace device_bridge {
namespace {

core::Pose SeenPose(const FrameReference& frame, const Sighting& seen, int role) noexcept {
  if (frame.is_hand) return seen.X_WHand[static_cast<std::size_t>(role)];
  return seen.X_WO[static_cast<std::size_t>(frame.object)] * frame.X_OF;
}

bool IsVisible(const FrameReference& frame, const Sighting& seen) noexcept {
  return frame.is_hand || seen.is_visible[static_cast<std::size_t>(frame.object)] != 0;
}

}  // namespace

// The moved frame M (reach: the hand itself; carry: a frame of the held object) shall coincide with the goal G, which
// is given in the seen frame F: X_WM_goal = X_WF X_FG. With the seen relation X_MHand = X_WM^-1 X_WHand the hand's goal
// is
//   X_WHand_goal = X_WF X_FG X_MHand.
Aim ComputeAim(const OperatorLine& line, const Sighting& seen) noexcept {
  Aim aim;
  aim.X_WHand = seen.X_WHand[static_cast<std::size_t>(line.role)];
  if (!IsVisible(line.goal, seen)) return aim;
  core::Pose X_WM = aim.X_WHand;
  if (line.verb == Verb::kCarry) {
    if (!IsVisible(line.moved, seen)) return aim;
    X_WM = SeenPose(line.moved, seen, line.role);
  }
  const core::Pose X_WM_goal = SeenPose(line.goal, seen, line.role) * line.X_FG;
  const core::Pose X_WHand_goal = X_WM_goal * (X_WM.inverse() * aim.X_WHand);
  aim.way_W = X_WHand_goal.translation - aim.X_WHand.translation;
  aim.turn_W = core::RotationVector(X_WHand_goal.rotation * glm::conjugate(aim.X_WHand.rotation));
  aim.distance_m = glm::length(X_WM_goal.translation - X_WM.translation);
  aim.angle_rad = glm::length(aim.turn_W);
  aim.is_valid = true;
  return aim;
}

bool IsSatisfied(const Condition& condition, const Sighting& seen, int role) noexcept {
  const auto mechanism = [&] { return seen.mechanisms[static_cast<std::size_t>(condition.mechanism)].state; };
  const std::uint16_t grasped = seen.grasped[static_cast<std::size_t>(role)];
  switch (condition.kind) {
    case ConditionKind::kNone:
      return false;
    case ConditionKind::kEngaged:
      return mechanism() == 1;
    case ConditionKind::kFree:
      return mechanism() == 0;
    case ConditionKind::kState:
      return mechanism() == condition.state;
    case ConditionKind::kHeld:
      return grasped == static_cast<std::uint16_t>(condition.object);
    case ConditionKind::kReleased:
      return grasped == core::kNoObject;
  }
  return false;
}

int StepIndexOf(const OperatorScript& script, const core::LogicStatus* logic) noexcept {
  if (logic == nullptr || logic->is_final) return -1;
  for (std::size_t i = 0; i < script.steps.size(); ++i) {
    if (script.steps[i].name == logic->step) return static_cast<int>(i);
  }
  return -1;
}

}  // namespace device_bridge
