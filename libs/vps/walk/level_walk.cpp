#include "vps/walk/level_walk.hpp"

#include <algorithm>
#include <cmath>

#include "vps/walk/walk_memory.hpp"

namespace vps {
namespace {

// With fewer blocks to test than this, a contact is not broad enough for coarser samples. Not derived: 1.5 times the
// blocks of kEnoughInside.
constexpr std::uint32_t kBroadBlocks = 96;
static_assert(kBroadBlocks * kBlock > kEnoughInside);
// Least number of blocks inside, of every seventh one, for a level to be evaluated. With kTooFewInside points inside,
// 48 blocks, the probe finds seven in the mean and five at worst of 2,000 poses of a peg. It must not refuse a level
// that has kTooFewInside: there the force would step.
constexpr double kLeastProbed = 4.0;

}  // namespace

std::uint32_t LevelWalk::Begin(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
                               double margin_m, InstructionSet set, FieldWalkScratch* scratch) {
  sampled_ = &sampled;
  field_ = &field;
  X_GS_ = X_GS;
  margin_m_ = margin_m;
  set_ = set;
  scratch_ = scratch;
  memory_ = scratch->memory;
  left_ = 1.0;
  const double ratio = static_cast<double>(sampled.num_points) / kPointsForThat;
  scale_ = std::sqrt(std::sqrt(std::max(ratio, 1.0)));
  points_due_ = points_tested_ = spheres_tested_ = 0;
  result_ = {};
  level_ = 0;
  scratch->ends_when_broad = !sampled.coarser.empty();
  const std::uint32_t num_chunks = PrepareWalk(sampled, field, X_GS, margin_m, set, scratch);
  scratch->ends_when_broad = false;
  return scratch->is_broad() ? DescendFrom(static_cast<std::uint32_t>(sampled.coarser.size())) : num_chunks;
}

// Prepares the coarsest level up to this that passes. A broad contact leaves no memory: a list would bypass the coarser
// samples.
std::uint32_t LevelWalk::DescendFrom(std::uint32_t level) {
  scratch_->memory = nullptr;
  for (level_ = level; level_ > 0; --level_) {
    const std::uint32_t num_chunks = PrepareWalk(TreeAt(level_), *field_, X_GS_, margin_m_, set_, scratch_);
    const std::uint32_t due = scratch_->points_due();
    if (due < kBroadBlocks * kBlock) continue;
    if (scratch_->most_points != 0 && due > scratch_->most_points)
      continue;  // over budget: the finest samples' deepest
    if (IsBroadInside(scratch_, kLeastProbed * scale_)) return num_chunks;
  }
  return PrepareWalk(*sampled_, *field_, X_GS_, margin_m_, set_, scratch_);
}

void LevelWalk::Add(const FieldWalkResult& walk, double share) {
  const FieldWalkResult sums = result_;
  result_ = walk;
  result_.force_m3 = sums.force_m3 + share * walk.force_m3;
  result_.moment_m4 = sums.moment_m4 + share * walk.moment_m4;
  result_.volume_m3 = sums.volume_m3 + share * walk.volume_m3;
  result_.square_m4 = sums.square_m4 + share * walk.square_m4;
}

std::uint32_t LevelWalk::Next() {
  for (;;) {
    const FieldWalkResult walk = FinishWalk(scratch_);
    points_due_ += scratch_->points_due();
    points_tested_ += walk.points_tested;
    spheres_tested_ += walk.spheres_tested;
    double share = left_;
    if (level_ > 0) {
      const double inside = static_cast<double>(walk.num_inside) / scale_;
      share *= std::clamp((inside - kTooFewInside) / (kEnoughInside - kTooFewInside), 0.0, 1.0);
    } else if (!sampled_->coarser.empty() && walk.spheres_tested == 0 &&
               walk.num_inside >= 3.0 * kTooFewInside * scale_) {
      // A contact that was small when the list was made has become broad.
      memory_->Forget();
      if (const auto n = DescendFrom(static_cast<std::uint32_t>(sampled_->coarser.size())); n > 0) return n;
      continue;
    }
    Add(walk, share);
    left_ -= share;
    if (level_ == 0 || !(left_ > 0.0)) break;
    if (const std::uint32_t num_chunks = DescendFrom(level_ - 1); num_chunks > 0) return num_chunks;
  }
  result_.points_tested = points_tested_;
  result_.spheres_tested = spheres_tested_;
  scratch_->memory = memory_;
  return 0;
}

}  // namespace vps
