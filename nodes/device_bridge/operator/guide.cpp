#include "nodes/device_bridge/operator/guide.hpp"

#include <algorithm>
#include <cmath>

#include "nodes/device_bridge/operator/script_sight.hpp"

namespace device_bridge {
namespace {

// Chosen by hand, with scenarios/ in mind.
constexpr double kNear_m = 0.0025;                      // of a goal at which something is done
constexpr double kOnTheWay_m = 0.012;                   // of a goal that only leads to the next
constexpr double kOpening_m = 0.003;                    // of the jaws
constexpr double kPushOn_m = 0.01;                      // beyond the hand, while a push waits for what it is for
constexpr std::int64_t kBeginAgain_ns = 4'000'000'000;  // as the scripted operator

bool IsMove(const OperatorLine& line) {
  return line.verb == Verb::kReach || line.verb == Verb::kCarry;
}

// Whether what is seen now shows that the line and all before it are done. An empty hand shows nothing.
bool IsMark(const OperatorLine& line, const Sighting& seen) {
  return line.until.kind != ConditionKind::kReleased && IsSatisfied(line.until, seen, line.role);
}

Tip MoveBy(const glm::dvec3& way_W, const glm::dvec3& turn_W, const core::Pose& X_WHand) {
  return {core::GuideKind::kMove,
          way_W,
          turn_W,
          {glm::normalize(core::QuaternionFromRotationVector(turn_W) * X_WHand.rotation), X_WHand.translation + way_W}};
}

}  // namespace

Guide::Guide(const scene::Scenario& scenario, const OperatorScript& script)
    : script_(script), sight_(scenario, 0.0), tips_(scenario.devices.size()) {}

void Guide::Step(const Inputs& inputs, const core::FixedVector<FeltForce, kMaxRoles>& felt,
                 const core::FixedVector<DeviceReading, kMaxRoles>& readings) noexcept {
  sight_.Record(inputs, readings, StepIndexOf(script_, inputs.logic));
  const Sighting* const seen = sight_.At(inputs.now_ns);
  std::fill(tips_.begin(), tips_.end(), Tip{});
  if (seen == nullptr) return;
  if (seen->step != step_) {
    step_ = seen->step;
    lines_ = step_ >= 0 ? &script_.steps[static_cast<std::size_t>(step_)].lines : nullptr;
    Begin(0, *seen);
  }
  if (lines_ == nullptr || lines_->empty()) return;
  FindLine(*seen, felt);
  if (line_ < lines_->size()) {
    tips_[static_cast<std::size_t>((*lines_)[line_].role)] = TipOf(line_, *seen);
  } else if (over_ns_ == 0) {
    over_ns_ = inputs.now_ns;
  } else if (inputs.now_ns - over_ns_ > kBeginAgain_ns) {
    Begin(0, *seen);
  }
}

void Guide::Begin(std::size_t line, const Sighting& seen) noexcept {
  line_ = line;
  over_ns_ = 0;
  if (lines_ == nullptr || line >= lines_->size()) return;
  p_WHand_begin_ = seen.X_WHand[static_cast<std::size_t>((*lines_)[line].role)].translation;
}

void Guide::FindLine(const Sighting& seen, const core::FixedVector<FeltForce, kMaxRoles>& felt) noexcept {
  for (std::size_t i = lines_->size(); i-- > line_;) {
    if (!IsMark((*lines_)[i], seen)) continue;
    Begin(i + 1, seen);
    break;
  }
  while (line_ < lines_->size() && IsDone(line_, seen, felt[static_cast<std::size_t>((*lines_)[line_].role)])) {
    Begin(line_ + 1, seen);
  }
}

double Guide::Progress(const OperatorLine& line, const Sighting& seen) const noexcept {
  return glm::dot(seen.X_WHand[static_cast<std::size_t>(line.role)].translation - p_WHand_begin_, line.direction_W);
}

// Jaws close on the part that is held next, or until they are shut; else they open, however far.
core::GuideKind Guide::KindOfGrip(std::size_t index) const noexcept {
  const bool grasps = index + 1 < lines_->size() && (*lines_)[index + 1].until.kind == ConditionKind::kHeld;
  return grasps || (*lines_)[index].opening_m < kOpening_m ? core::GuideKind::kClose : core::GuideKind::kOpen;
}

bool Guide::IsDone(std::size_t index, const Sighting& seen, const FeltForce& felt) const noexcept {
  const OperatorLine& line = (*lines_)[index];
  switch (line.verb) {
    case Verb::kReach:
    case Verb::kCarry: {
      const bool leads_on = index + 1 < lines_->size() && IsMove((*lines_)[index + 1]);
      const double near_m = std::max(line.within_m, leads_on ? kOnTheWay_m : kNear_m);
      const Aim aim = ComputeAim(line, seen);
      return aim.is_valid && std::max(aim.distance_m, kLever_m * aim.angle_rad) <= near_m;
    }
    case Verb::kPush:
      if (line.until.kind != ConditionKind::kNone) return IsSatisfied(line.until, seen, line.role);
      if (line.until_felt_N > 0.0) return -glm::dot(felt.F_Do_W.force_N, line.direction_W) >= line.until_felt_N;
      return Progress(line, seen) >= line.distance_m - kNear_m;
    case Verb::kGrip:
      if (KindOfGrip(index) == core::GuideKind::kOpen) return felt.opening_m >= line.opening_m - kOpening_m;
      return felt.opening_m <= line.opening_m + kOpening_m ||
             seen.grasped[static_cast<std::size_t>(line.role)] != core::kNoObject;
    case Verb::kWait:
      return line.until.kind == ConditionKind::kNone || IsSatisfied(line.until, seen, line.role);
  }
  return false;
}

Tip Guide::TipOf(std::size_t index, const Sighting& seen) const noexcept {
  const OperatorLine& line = (*lines_)[index];
  switch (line.verb) {
    case Verb::kReach:
    case Verb::kCarry: {
      const Aim aim = ComputeAim(line, seen);
      if (!aim.is_valid) return {core::GuideKind::kWait, {}, {}, {}};
      return MoveBy(aim.way_W, aim.turn_W, aim.X_WHand);
    }
    case Verb::kPush: {
      const double goal_m = std::max(line.distance_m, Progress(line, seen) + kPushOn_m);
      const glm::dvec3 p_W = p_WHand_begin_ + goal_m * line.direction_W;
      const core::Pose& X_WHand = seen.X_WHand[static_cast<std::size_t>(line.role)];
      return MoveBy(p_W - X_WHand.translation, {}, X_WHand);
    }
    case Verb::kGrip:
      return {KindOfGrip(index), {}, {}, {}};
    case Verb::kWait:
      return {core::GuideKind::kWait, {}, {}, {}};
  }
  return {};
}

}  // namespace device_bridge
