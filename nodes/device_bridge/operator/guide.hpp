#pragma once

#include <vector>

#include "core/hand_guide.hpp"
#include "nodes/device_bridge/hand.hpp"
#include "nodes/device_bridge/operator/operator_script.hpp"
#include "nodes/device_bridge/operator/perception.hpp"

namespace device_bridge {

// What a person who steers a hand does next.
struct Tip {
  core::GuideKind kind = core::GuideKind::kNone;
  glm::dvec3 way_W_m{0.0};  // from where the hand is; of kMove
  glm::dvec3 turn_W_rad{0.0};
  core::Pose X_WG;  // the goal itself
};

// Shows a person the next goal: the scripted operator's line that the scene has come to. It only looks, so a line is
// done when what it is for is seen, whoever did it and in whatever order; a person who already holds the part is not
// told to fetch it.
class Guide {
 public:
  Guide(const scene::Scenario& scenario, const OperatorScript& script);
  Guide(const Guide&) = delete;

  // One tick. Real-time: no allocation.
  void Step(const Inputs& inputs, const core::FixedVector<FeltForce, kMaxRoles>& felt,
            const core::FixedVector<DeviceReading, kMaxRoles>& readings) noexcept;
  [[nodiscard]] const Tip& tip(std::size_t role) const { return tips_[role]; }

 private:
  void FindLine(const Sighting& seen, const core::FixedVector<FeltForce, kMaxRoles>& felt) noexcept;
  void Begin(std::size_t line, const Sighting& seen) noexcept;
  [[nodiscard]] bool IsDone(std::size_t index, const Sighting& seen, const FeltForce& felt) const noexcept;
  [[nodiscard]] Tip TipOf(std::size_t index, const Sighting& seen) const noexcept;
  // Metres along the push's direction since it began.
  [[nodiscard]] double Progress(const OperatorLine& line, const Sighting& seen) const noexcept;
  [[nodiscard]] core::GuideKind KindOfGrip(std::size_t index) const noexcept;

  const OperatorScript& script_;
  DelayedSight sight_;
  std::vector<Tip> tips_;                             // per role
  const std::vector<OperatorLine>* lines_ = nullptr;  // of the present step
  int step_ = -1;
  std::size_t line_ = 0;
  glm::dvec3 p_WHand_begin_{0.0};  // when the line began
  std::int64_t over_ns_ = 0;       // since then all lines are done, and the step is not
};

}  // namespace device_bridge
