#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <vector>

#include "core/pose.hpp"
#include "vps/walk/evaluate_points.hpp"

namespace vps {

// Weight of the exact depth against the field's depth d [voxels]: 1 at the surface, 0 where d > kExactInside, since
// there the field's error is small against d, and where the point is farther outside than kExactOutside; linear
// between, so that the corrected depth is continuous. Not derived: more takes time for depths that change little.
constexpr float kExactInside = 2.0f;
constexpr float kExactOutside = 0.1f;
constexpr float kExactFade = 0.05f;
inline float ShareOfExact(float depth) {
  const float outside = (depth + kExactOutside) * (1.0f / kExactFade);
  return std::clamp(std::min(outside, kExactInside - depth), 0.0f, 1.0f);
}

// Corrects depths by the field towards exact ones, point by point. Points are collected in groups that fill registers
// and are no larger than a few voxels; each goes to one of the last kOpen groups if it lies near enough. The result of
// a point does not depend on the others in its group. Allocated once.
class ExactDepths {
 public:
  ExactDepths();

  // Begins with a field that has facets. share, in [0, 1]: weight of the exact depths, times ShareOfExact. Corrections
  // are added to `depths`, [block].of[lane], voxels.
  void Begin(const DistanceField& field, const core::Pose& X_GS, float share, BlockDepths* depths);
  // The depth of one point of a block. p_S: m; depth: by the field, voxels.
  void Add(const glm::vec3& p_S, float depth, std::uint32_t block, std::uint32_t lane);
  void End();

 private:
  static constexpr std::uint32_t kMostGroups = 32;  // kMostGroups and kOpen: not derived
  static constexpr std::uint32_t kOpen = 4;
  struct Target {
    float before = 0.0f;
    std::uint32_t block = 0;
    std::uint32_t lane = 0;
  };
  void Fill(std::uint32_t group);
  void Flush();

  const DistanceField* field_ = nullptr;
  core::Pose X_GS_;
  float share_ = 1.0f;
  float group_m_ = 0.0f;
  BlockDepths* depths_ = nullptr;
  std::vector<FacetPoints> groups_;
  std::vector<Target> targets_;
  std::array<std::uint32_t, kMostGroups> sizes_{};
  std::uint32_t num_groups_ = 0;  // the last kOpen may be open
  std::unique_ptr<FacetScratch> scratch_;
};

}  // namespace vps
