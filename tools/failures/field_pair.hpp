#pragma once

#include <memory>

#include "collision/owned_world.hpp"
#include "core/parallel_for.hpp"
#include "tools/failures/scene_kit.hpp"

namespace failures {

// Points of one mesh against the field of another, as in haptic_node's collision world.
class FieldPair {
 public:
  // Which of the two the hand is: its pairs are those of the coupling.
  enum class Palm { kNone, kSampled, kField };

  FieldPair(const Variant& variant, const vps::TriangleMesh& field, double voxel_m, const vps::TriangleMesh& sampled,
            std::uint32_t num_points, Palm palm = Palm::kNone);
  // The sampled mesh at this pose in the field's frame. `budget_points` 0: no limit.
  const vps::PairResult& Query(const core::Pose& X_GS, std::uint64_t budget_points = 0);
  [[nodiscard]] const vps::StepReport& report() const { return *report_; }
  [[nodiscard]] const vps::CookedObject& field() const { return *owned_.data[0]; }
  [[nodiscard]] const vps::CookedObject& sampled() const { return *owned_.data[1]; }

 private:
  core::SerialFor serial_;
  collision::OwnedWorld owned_;
  const vps::StepReport* report_ = nullptr;
};

}  // namespace failures
