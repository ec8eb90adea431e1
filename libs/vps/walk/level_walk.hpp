#pragma once

#include <cstdint>

#include "vps/walk/field_walk.hpp"

namespace vps {

// A broad contact needs fewer points than the samples that find a small one: where many points of SampleTree::coarser
// are well inside, their sums are within a percent of those of all samples, at a quarter of the cost. What is lost is
// at a contact's rim, so those count whose whole block collides (FieldWalkResult::num_inside): from kEnoughInside on
// the coarser samples answer alone, below kTooFewInside the next finer ones, and all of them in the end; between the
// two both do, in proportion, so that the sums stay continuous. They depend on the pose alone. Who gives more than
// kPointsForThat points wants more of the contact to be seen: both numbers grow with the fourth root of the number of
// points.
constexpr double kTooFewInside = 768.0;
constexpr double kEnoughInside = 1024.0;
constexpr std::uint32_t kPointsForThat = 65536;

// A walk by levels, in parts as FieldWalk's: chunks may be evaluated by several threads, EvaluateChunk(scratch, i) for
// i below what Begin or Next returned.
class LevelWalk {
 public:
  // How many chunks are to be evaluated before Next.
  std::uint32_t Begin(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS, double margin_m,
                      InstructionSet set, FieldWalkScratch* scratch);
  // 0: done. Else so many chunks of finer samples are to be evaluated first.
  std::uint32_t Next();

  // When done: sums of all levels that took part, everything else of the finest of them.
  [[nodiscard]] const FieldWalkResult& result() const { return result_; }
  [[nodiscard]] const SampleTree& finest() const { return TreeAt(level_); }
  [[nodiscard]] bool is_coarse() const { return level_ > 0; }
  [[nodiscard]] std::uint32_t points_due() const { return points_due_; }

 private:
  [[nodiscard]] const SampleTree& TreeAt(std::uint32_t level) const {
    return level == 0 ? *sampled_ : sampled_->coarser[level - 1];
  }
  std::uint32_t DescendFrom(std::uint32_t level);
  void Add(const FieldWalkResult& walk, double share);

  const SampleTree* sampled_ = nullptr;
  const DistanceField* field_ = nullptr;
  core::Pose X_GS_;
  double margin_m_ = 0.0;
  InstructionSet set_{};
  FieldWalkScratch* scratch_ = nullptr;
  FieldWalkMemory* memory_ = nullptr;
  std::uint32_t level_ = 0;  // 0: the samples themselves; k: coarser[k - 1]
  double left_ = 1.0;        // share of the levels that are yet to come
  double scale_ = 1.0;       // of kTooFewInside and kEnoughInside
  std::uint32_t points_due_ = 0, points_tested_ = 0, spheres_tested_ = 0;
  FieldWalkResult result_;
};

}  // namespace vps
