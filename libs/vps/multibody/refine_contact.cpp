#include "vps/multibody/refine_contact.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "vps/multibody/block_sums.hpp"

namespace vps {
namespace {

// The whole fades out between so many samples, weighted, and twice as many. Of a part that has few samples for all of
// its surface, later: there a contact of as many is as broad as it gets, and its rim is all that they see.
constexpr float kFewSamples = 160.0f;
constexpr float kFewOfCoarsePart = 1280.0f;
constexpr std::uint32_t kCoarsePart = 8192;
constexpr std::uint32_t kMostSamples = 4096;

// How far the depth may vary within a patch, beside what it varies within the whole block of samples.
constexpr float kSteeper = 3.0f;
constexpr float kLeastSlope = 0.02f;

// Of the depths of a block's points.
float Spread(const PointBlock& block, const float* depths) {
  float least = 1e30f;
  float most = -1e30f;
  for (std::uint32_t k = 0; k < kBlock; ++k) {
    const bool is_point = block.area_m2[k] > 0.0f;
    least = std::min(least, is_point ? depths[k] : least);
    most = std::max(most, is_point ? depths[k] : most);
  }
  return most - least;
}

// Samples that may be inside G: those no farther outside than their patch reaches towards G. Its reach along the
// surface counts by how steeply the depth changes there, seen from the samples of its block: in a conforming contact
// the whole free side is nearer than its samples are to each other. Returns how much of the refinement their number
// leaves.
float FindSamples(const SampleTree& sampled, float voxel_m, const FieldWalkResult& walk,
                  const FieldWalkScratch& walk_scratch, RefineScratch* scratch) {
  const auto most_m2 = static_cast<float>(sampled.refined_m * sampled.refined_m);
  const float few = sampled.num_points <= kCoarsePart ? kFewOfCoarsePart : kFewSamples;
  float sum = 0.0f;
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < walk.num_near_blocks; ++i) {
    const std::uint32_t at = walk_scratch.near_blocks[i];
    const PointBlock& block = sampled.points[at];
    const float* const depths = walk_scratch.depths(i);
    const float radius_m = sampled.spheres[at / kBlock].r[at % kBlock];
    const float slope = Spread(block, depths) * voxel_m / (2.0f * radius_m);
    const float steep = std::min(1.0f, kSteeper * slope + kLeastSlope);
    for (std::uint32_t first = 0; first < kBlock; first += 4) {
      const F4 depth_m = LoadF4(depths + first) * voxel_m;
      const F4 outside_m = depth_m < 0.0f ? depth_m : F4{};
      const F4 patch_m2 = LoadF4(block.area_m2 + first) * (kPatchReach * kPatchReach);
      const F4 reach_m2 = (patch_m2 < most_m2 ? patch_m2 : F4{} + most_m2) * (steep * steep);
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
    if (sum >= 2.0f * few) return 0.0f;
  }
  scratch->num_samples = count;
  return std::clamp((2.0f * few - sum) / few, 0.0f, 1.0f);
}

// The finer points of a sample, as number j of those evaluated together.
void Place(const SampleTree& sampled, std::uint32_t at, const FinerSample& sample, std::uint32_t j,
           RefineScratch* scratch) {
  const PointBlock& block = sampled.points[at];
  const FineBlock& fine = sampled.fine[std::size_t{at} * kBlock + sample.lane];
  Unpack(fine, block, sample.lane, sample.weight, &scratch->points[j]);
  SphereBlock& spheres = scratch->spheres[j / kBlock];
  spheres.x[j % kBlock] = block.x[sample.lane];
  spheres.y[j % kBlock] = block.y[sample.lane];
  spheres.z[j % kBlock] = block.z[sample.lane];
  spheres.r[j % kBlock] = fine.reach_m;
}

// What the finer points at these depths change in what the sample, a point of `block`, tells.
void FindChange(const PointBlock& block, const PointBlock& points, const float* depths, float voxel_m,
                FinerSample* sample) {
  const std::uint32_t k = FindDeepest(depths);
  sample->change.p_S = PointOf(points, k);
  sample->change.penetration_m = depths[k] * voxel_m;
  if (depths[k] > 0.0f) {
    SetSums(points, depths, voxel_m, &sample->change);
  } else {
    SetSums(points, 0U, 0.0f, &sample->change);
  }
  if (!(sample->depth_m > 0.0f)) return;
  ContactPatch coarse;
  SetSums(block, sample->lane, sample->depth_m, &coarse);
  AddSums(coarse, -sample->weight, &sample->change);
}

}  // namespace

RefineScratch::RefineScratch()
    : samples(kMostSamples),
      points(kMostBlocksAtOnce),
      spheres(kMostBlocksAtOnce / kBlock),
      depths(kMostBlocksAtOnce) {}

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
  for (std::uint32_t begin = 0; begin < scratch->num_samples; begin += kMostBlocksAtOnce) {
    const std::uint32_t count = std::min(kMostBlocksAtOnce, scratch->num_samples - begin);
    const std::span<FinerSample> samples(scratch->samples.data() + begin, count);
    for (std::uint32_t j = 0; j < count; ++j) {
      samples[j].weight *= share;
      Place(sampled, walk_scratch.near_blocks[samples[j].near_block], samples[j], j, scratch);
    }
    FindDepths(scratch->points.data(), scratch->spheres.data(), count, field, X_GS, scratch->depths.data());
    for (std::uint32_t j = 0; j < count; ++j) {
      const PointBlock& block = sampled.points[walk_scratch.near_blocks[samples[j].near_block]];
      FindChange(block, scratch->points[j], scratch->depths[j].of, voxel_m, &samples[j]);
    }
  }
}

}  // namespace vps
