#include "vps/multibody/exact_depths.hpp"

#include <algorithm>

namespace vps {
namespace {

// Radius of a group about its first point, voxels. Not derived: wider groups are fuller, but near more facets.
constexpr float kWidestGroup = 1.5f;

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
  const auto has_room_near = [&](std::uint32_t i) {
    const glm::vec3 from = p_S - glm::vec3(groups_[i].x[0], groups_[i].y[0], groups_[i].z[0]);
    return sizes_[i] < kBlock && glm::dot(from, from) <= group_m_ * group_m_;
  };
  const std::uint32_t first = num_groups_ > kOpen ? num_groups_ - kOpen : 0;
  std::uint32_t i = first;
  while (i < num_groups_ && !has_room_near(i)) ++i;
  if (i == num_groups_) {
    if (num_groups_ == kMostGroups) {
      Flush();
      i = 0;
    }
    sizes_[num_groups_++] = 0;
  }
  FacetPoints& group = groups_[i];
  const std::uint32_t k = sizes_[i]++;
  group.x[k] = p_S.x;
  group.y[k] = p_S.y;
  group.z[k] = p_S.z;
  group.depth[k] = depth;
  targets_[i * kBlock + k] = {depth, block, lane};
}

void ExactDepths::End() {
  Flush();
}

// Fills a group up with its last point.
void ExactDepths::Fill(std::uint32_t i) {
  FacetPoints& group = groups_[i];
  const std::uint32_t last = sizes_[i] - 1;
  for (std::uint32_t k = last + 1; k < kBlock; ++k) {
    group.x[k] = group.x[last];
    group.y[k] = group.y[last];
    group.z[k] = group.z[last];
    group.depth[k] = group.depth[last];
  }
}

void ExactDepths::Flush() {
  for (std::uint32_t i = 0; i < num_groups_; ++i) Fill(i);
  ComputeExactDepths(*field_, X_GS_, BestInstructionSet(), {groups_.data(), num_groups_}, scratch_.get());
  for (std::uint32_t i = 0; i < num_groups_; ++i) {
    for (std::uint32_t k = 0; k < sizes_[i]; ++k) {
      const Target& target = targets_[i * kBlock + k];
      const float change = std::clamp(groups_[i].depth[k] - target.before, -kMostFieldError, kMostFieldError);
      depths_[target.block].of[target.lane] += share_ * ShareOfExact(target.before) * change;
    }
  }
  num_groups_ = 0;
}

}  // namespace vps
