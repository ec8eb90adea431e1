#pragma once

#include <cstdint>

#include "vps/walk/field_walk.hpp"

namespace vps {

// Adaptive number of points: a broad contact needs fewer than a small one. Where many points of SampleTree::coarser are
// well inside, their sums are within a percent of those of all samples, at a quarter of the cost. The error is at a
// contact's rim, so that the criterion counts the points n whose whole block collides (FieldWalkResult::num_inside).
// The coarsest level with n > kTooFewInside counts with the weight
//
//   w = clamp((n / c - kTooFewInside) / (kEnoughInside - kTooFewInside), 0, 1),   c = max(1, N / kPointsForThat)^(1/4),
//
// and the next finer one with the rest, so that the sums are continuous. They depend on the pose alone. With more than
// kPointsForThat samples N more is wanted, by c: more points give more accuracy. The numbers: table of decision 11.
constexpr double kTooFewInside = 768.0;
constexpr double kEnoughInside = 1024.0;
constexpr std::uint32_t kPointsForThat = 65536;

// A walk by levels, in parts as WalkField's: chunks may be evaluated by several threads, EvaluateChunk(scratch, i) for
// i below the number that Begin or Next returned.
class LevelWalk {
 public:
  // The number of chunks to evaluate before Next.
  std::uint32_t Begin(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS, double margin_m,
                      InstructionSet set, FieldWalkScratch* scratch);
  // The number of chunks of finer samples to evaluate before the next call; 0: done.
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
