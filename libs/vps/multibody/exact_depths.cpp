#include "vps/multibody/exact_depths.hpp"

#include <algorithm>

namespace vps {
namespace {

constexpr float kWidestGroup = 1.5f;  // voxels from its first point

}  // namespace

ExactDepths::ExactDepths()
    : groups_(kMostGroups), targets_(kMostGroups * kBlock), scratch_(std::make_unique<FacetScratch>()) {}

void ExactDepths::Begin(const DistanceField& field, const core::Pose& X_GS, float share, BlockDepths* depths) {
  field_ = &field;
  X_GS_ = X_GS;
  share_ = share;
  group_m_ = kWidestGroup * static_cast<float>(field.voxel_size_m);
  depths_ = depths;
  num_groups_ = 0;
}

void ExactDepths::Add(const glm::vec3& p_S, float depth, std::uint32_t block, std::uint32_t lane) {
  bool is_new = num_groups_ == 0 || sizes_[num_groups_ - 1] == kBlock;
  if (!is_new) {
    const FacetPoints& open = groups_[num_groups_ - 1];
    const glm::vec3 from = p_S - glm::vec3(open.x[0], open.y[0], open.z[0]);
    is_new = glm::dot(from, from) > group_m_ * group_m_;
  }
  if (is_new) {
    CloseGroup();
    if (num_groups_ == kMostGroups) Flush();
    sizes_[num_groups_++] = 0;
  }
  FacetPoints& group = groups_[num_groups_ - 1];
  const std::uint32_t k = sizes_[num_groups_ - 1]++;
  group.x[k] = p_S.x;
  group.y[k] = p_S.y;
  group.z[k] = p_S.z;
  group.depth[k] = depth;
  targets_[(num_groups_ - 1) * kBlock + k] = {depth, block, lane};
}

void ExactDepths::End() {
  CloseGroup();
  Flush();
}

// The last point stands for those that are missing.
void ExactDepths::CloseGroup() {
  if (num_groups_ == 0) return;
  FacetPoints& group = groups_[num_groups_ - 1];
  const std::uint32_t last = sizes_[num_groups_ - 1] - 1;
  for (std::uint32_t k = last + 1; k < kBlock; ++k) {
    group.x[k] = group.x[last];
    group.y[k] = group.y[last];
    group.z[k] = group.z[last];
    group.depth[k] = group.depth[last];
  }
}

void ExactDepths::Flush() {
  MeasureDepths(*field_, X_GS_, BestInstructionSet(), {groups_.data(), num_groups_}, scratch_.get());
  for (std::uint32_t i = 0; i < num_groups_; ++i) {
    for (std::uint32_t k = 0; k < sizes_[i]; ++k) {
      const Target& target = targets_[i * kBlock + k];
      const float change = share_ * std::clamp(groups_[i].depth[k] - target.before, -kMostFieldError, kMostFieldError);
      float* const depths = depths_[target.block].of;
      const std::uint32_t begin = target.lane == kBlock ? 0 : target.lane;
      const std::uint32_t end = target.lane == kBlock ? kBlock : target.lane + 1;
      for (std::uint32_t lane = begin; lane < end; ++lane) depths[lane] += ShareOfExact(depths[lane]) * change;
    }
  }
  num_groups_ = 0;
}

}  // namespace vps
