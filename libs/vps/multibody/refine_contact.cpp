#include "vps/multibody/refine_contact.hpp"

#include <algorithm>
#include <cmath>

#include "vps/multibody/block_sums.hpp"

namespace vps {
namespace {

// The whole fades out between so many samples, weighted.
constexpr float kFewSamples = 160.0f;
constexpr float kManySamples = 320.0f;
constexpr std::uint32_t kMostSamples = 640;
static_assert(kMostSamples <= kMostBlocksAtOnce);

// Samples that may be inside G: those no farther outside than their patch reaches. Returns how much of the refinement
// their number leaves.
float FindSamples(const SampleTree& sampled, float voxel_m, const FieldWalkResult& walk,
                  const FieldWalkScratch& walk_scratch, RefineScratch* scratch) {
  const auto most_m2 = static_cast<float>(sampled.refined_m * sampled.refined_m);
  float sum = 0.0f;
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < walk.num_near_blocks; ++i) {
    const std::uint32_t at = walk_scratch.near_blocks[i];
    const PointBlock& block = sampled.points[at];
    const float* const depths = walk_scratch.depths(i);
    for (std::uint32_t first = 0; first < kBlock; first += 4) {
      const F4 depth_m = LoadF4(depths + first) * voxel_m;
      const F4 outside_m = depth_m < 0.0f ? depth_m : F4{};
      const F4 patch_m2 = LoadF4(block.area_m2 + first) * (kPatchReach * kPatchReach);
      const F4 reach_m2 = patch_m2 < most_m2 ? patch_m2 : F4{} + most_m2;
      const F4 near = reach_m2 - outside_m * outside_m;
      const I4 is_near = near > 0.0f;
      if ((is_near[0] | is_near[1] | is_near[2] | is_near[3]) == 0) continue;
      const F4 weight = 2.0f * near / reach_m2;
      for (std::uint32_t j = 0; j < 4; ++j) {
        if (is_near[j] == 0) continue;
        if (count == kMostSamples) return 0.0f;
        FinerSample& sample = scratch->samples[count++];
        sample.near_block = i;
        sample.lane = first + j;
        sample.depth_m = depth_m[j];
        sample.weight = std::min(weight[j], 1.0f);
        sum += sample.weight;
        const auto* const fine = reinterpret_cast<const char*>(&sampled.fine[std::size_t{at} * kBlock + first + j]);
        for (std::size_t line = 0; line < sizeof(FineBlock); line += 64) __builtin_prefetch(fine + line);
      }
    }
    if (sum >= kManySamples) return 0.0f;
  }
  scratch->num_samples = count;
  return std::clamp((kManySamples - sum) / (kManySamples - kFewSamples), 0.0f, 1.0f);
}

}  // namespace

RefineScratch::RefineScratch()
    : samples(kMostSamples), points(kMostSamples), spheres(kMostSamples / kBlock), depths(kMostSamples) {}

void RefineContact(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
                   const FieldWalkResult& walk, const FieldWalkScratch& walk_scratch, RefineScratch* scratch) {
  scratch->num_samples = 0;
  if (sampled.fine.empty()) return;
  const auto voxel_m = static_cast<float>(field.voxel_size_m);
  const float share = FindSamples(sampled, voxel_m, walk, walk_scratch, scratch);
  if (!(share > 0.0f)) {
    scratch->num_samples = 0;
    return;
  }
  const std::uint32_t count = scratch->num_samples;
  for (std::uint32_t j = 0; j < count; ++j) {
    FinerSample& sample = scratch->samples[j];
    sample.weight *= share;
    const std::uint32_t at = walk_scratch.near_blocks[sample.near_block];
    const PointBlock& block = sampled.points[at];
    const FineBlock& fine = sampled.fine[std::size_t{at} * kBlock + sample.lane];
    Unpack(fine, block, sample.lane, sample.weight, &scratch->points[j]);
    SphereBlock& spheres = scratch->spheres[j / kBlock];
    spheres.x[j % kBlock] = block.x[sample.lane];
    spheres.y[j % kBlock] = block.y[sample.lane];
    spheres.z[j % kBlock] = block.z[sample.lane];
    spheres.r[j % kBlock] = fine.reach_m;
  }
  FindDepths(scratch->points.data(), scratch->spheres.data(), count, field, X_GS, scratch->depths.data());
  for (std::uint32_t j = 0; j < count; ++j) {
    FinerSample& sample = scratch->samples[j];
    const PointBlock& points = scratch->points[j];
    const float* const depths = scratch->depths[j].of;
    const std::uint32_t k = FindDeepest(depths);
    sample.change.p_S = PointOf(points, k);
    sample.change.penetration_m = depths[k] * voxel_m;
    if (depths[k] > 0.0f) {
      SetSums(points, depths, voxel_m, &sample.change);
    } else {
      SetSums(points, 0U, 0.0f, &sample.change);
    }
    if (!(sample.depth_m > 0.0f)) continue;
    ContactPatch coarse;
    SetSums(sampled.points[walk_scratch.near_blocks[sample.near_block]], sample.lane, sample.depth_m, &coarse);
    AddSums(coarse, -sample.weight, &sample.change);
  }
}

}  // namespace vps
