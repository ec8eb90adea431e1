#include "vps/walk/walk_memory.hpp"

#include <algorithm>

namespace vps {

double MotionBound(const core::Pose& X_GS_before, const core::Pose& X_GS_now, const glm::dvec3& centre_S,
                   double radius_m) {
  const glm::dquat turn = glm::conjugate(X_GS_before.rotation) * X_GS_now.rotation;
  return glm::length(X_GS_now * centre_S - X_GS_before * centre_S) +
         2.0 * glm::length(glm::dvec3(turn.x, turn.y, turn.z)) * radius_m;
}

double FieldWalkMemory::Moved(const core::Pose& X_GS_before, const core::Pose& X_GS_now) const {
  return MotionBound(X_GS_before, X_GS_now, sampled_->centre_m, sampled_->radius_m) / field_->voxel_size_m + kRounding;
}

// Quick bound for pairs that stay apart, from translations and quaternions alone. MotionBound needs |v|, the vector
// part of the relative quaternion with scalar w; the difference of the two quaternions has the squared length 2 (1 - w)
// >= 1 - w^2 = |v|^2. 0 where the bound may be too rough.
double FieldWalkMemory::FreeAtLeast(const core::Pose& X_GS) const {
  if (state_ != State::kApart) return 0.0;
  const glm::dvec4 turn(X_GS.rotation.w - X_GS_.rotation.w, X_GS.rotation.x - X_GS_.rotation.x,
                        X_GS.rotation.y - X_GS_.rotation.y, X_GS.rotation.z - X_GS_.rotation.z);
  const double moved_m = glm::length(X_GS.translation - X_GS_.translation) + 2.0 * glm::length(turn) * farthest_m_;
  const double free = free_voxels_ - (moved_m / field_->voxel_size_m + kRounding);
  return std::max(free, 0.0);
}

double FieldWalkMemory::RemainingFreeDistance_m(const SampleTree& sampled, const DistanceField& field,
                                                const core::Pose& X_GS, double margin_m) {
  if (sampled_ != &sampled || field_ != &field || margin_m_ != margin_m) return 0.0;
  const double free = FreeAtLeast(X_GS);
  if (free > 0.0) X_GS_last_ = X_GS;
  return free * field.voxel_size_m;
}

FieldWalkMemory::Advice FieldWalkMemory::Advise(const SampleTree& sampled, const DistanceField& field,
                                                const core::Pose& X_GS, double margin_m) {
  if (sampled_ != &sampled || field_ != &field || margin_m_ != margin_m) {
    sampled_ = &sampled;
    field_ = &field;
    margin_m_ = margin_m;
    X_GS_last_ = X_GS;
    state_ = State::kNothing;
    farthest_m_ = glm::length(sampled.centre_m) + sampled.radius_m;
    return {Advice::kStartAnew, 0.0};
  }
  if (const double free = FreeAtLeast(X_GS); free > 0.0) {
    X_GS_last_ = X_GS;
    return {Advice::kStayApart, free};
  }
  const core::Pose X_GS_last = X_GS_last_;
  X_GS_last_ = X_GS;
  if (state_ != State::kNothing) {
    const double moved = Moved(X_GS_, X_GS);
    if (state_ == State::kApart && moved < free_voxels_) return {Advice::kStayApart, free_voxels_ - moved};
    if (state_ == State::kList && moved < skin_voxels_) return {Advice::kUseList, moved};
    state_ = State::kNothing;
  }
  const double skin = kCyclesOfList * Moved(X_GS_last, X_GS);
  if (skin > kWidestSkin || num_tested_ > kMostBlocks / 4) return {Advice::kStartAnew, 0.0};
  return {Advice::kMakeList, std::max(skin, kLeastSkin)};
}

void FieldWalkMemory::KeepApart(double free_voxels) {
  if (free_voxels <= (state_ == State::kList ? skin_voxels_ : 0.0)) return;
  X_GS_ = X_GS_last_;
  state_ = State::kApart;
  free_voxels_ = free_voxels;
}

void FieldWalkMemory::KeepList(double skin_voxels, double free_voxels, std::span<const std::uint32_t> blocks,
                               const float* slacks) {
  if (blocks.size() > kMostBlocks) return;
  X_GS_ = X_GS_last_;
  state_ = State::kList;
  skin_voxels_ = skin_voxels;
  free_voxels_ = free_voxels;
  num_blocks_ = static_cast<std::uint32_t>(blocks.size());
  std::copy(blocks.begin(), blocks.end(), blocks_.begin());
  std::copy(slacks, slacks + blocks.size(), slacks_.begin());
}

std::uint32_t FieldWalkMemory::Select(double moved_voxels, std::uint32_t* blocks, double* free_voxels) const {
  const auto moved = static_cast<float>(moved_voxels);
  std::uint32_t count = 0;
  auto free = static_cast<float>(free_voxels_);
  for (std::uint32_t i = 0; i < num_blocks_; ++i) {
    const bool is_due = slacks_[i] <= moved;
    blocks[count] = blocks_[i];
    count += is_due ? 1 : 0;
    free = std::min(free, is_due ? free : slacks_[i]);
  }
  *free_voxels = static_cast<double>(free) - moved_voxels;
  return count;
}

}  // namespace vps
