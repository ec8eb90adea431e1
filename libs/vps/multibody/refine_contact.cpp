#include "vps/multibody/refine_contact.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "vps/multibody/block_sums.hpp"

namespace vps {
namespace {

// The whole fades out between so many samples, weighted, and twice as many. Of a part that has few samples for all of
// its surface, later: there a contact of as many is as broad as it gets, and its rim is all that they see.
constexpr float kFewSamples = 320.0f;
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

// Depths are made exact while so many of them are wanted, and less and less up to kManyDepths: then the field's errors
// average out, and exact depths would take longer than all the rest.
constexpr float kFewDepths = 112.0f;
constexpr float kManyDepths = 144.0f;
// A patch smaller than this is told by the depth at its sample: the field's error hardly changes across it.
constexpr float kSmallPatch = 0.4f;  // voxels

bool IsSmall(float area_m2, float voxel_m) {
  return area_m2 < kSmallPatch * kSmallPatch * voxel_m * voxel_m;
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

// The finer points of these samples, at most kMostBlocksAtOnce, and their depths by the field.
void FindFineDepths(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
                    const FieldWalkScratch& walk_scratch, std::span<const FinerSample> samples,
                    RefineScratch* scratch) {
  for (std::uint32_t j = 0; j < samples.size(); ++j) {
    Place(sampled, walk_scratch.near_blocks[samples[j].near_block], samples[j], j, scratch);
  }
  FindDepths(scratch->points.data(), scratch->spheres.data(), static_cast<std::uint32_t>(samples.size()), field, X_GS,
             scratch->depths.data());
}

// How much longer an exact depth takes than in a small patch: the farther points lie apart, the more facets come into
// question for some of those that share a register.
float Effort(float area_m2, float voxel_m) {
  return 1.0f + 0.5f * area_m2 / (voxel_m * voxel_m);
}

// Of four depths at points of these areas.
F4 SharesOfExact(const F4& depth, const F4& area_m2) {
  const F4 outside = (depth + kExactOutside) * (1.0f / kExactFade);
  const F4 deep = kExactInside - depth;
  const F4 least = outside < deep ? outside : deep;
  const F4 share = least < 1.0f ? least : F4{} + 1.0f;
  return ((share > 0.0f) & (area_m2 > 0.0f)) ? share : F4{};
}

// How many exact depths these samples ask for by their weights: one if the patch is small, else as many as finer points
// lie inside. May end when it is kManyDepths.
float CountWanted(const SampleTree& sampled, float voxel_m, const FieldWalkScratch& walk_scratch,
                  std::span<const FinerSample> samples, const RefineScratch& scratch) {
  float wanted = 0.0f;
  for (std::uint32_t j = 0; j < samples.size() && wanted < kManyDepths; ++j) {
    const float* const depths = scratch.depths[j].of;
    const float* const areas_m2 = scratch.points[j].area_m2;
    F4 sum{};
    F4 most{};
    for (std::uint32_t k = 0; k < kBlock; k += 4) {
      const F4 share = SharesOfExact(LoadF4(depths + k), LoadF4(areas_m2 + k));
      sum += share;
      most = share > most ? share : most;
    }
    const float area_m2 = sampled.points[walk_scratch.near_blocks[samples[j].near_block]].area_m2[samples[j].lane];
    const float largest = std::max(std::max(most[0], most[1]), std::max(most[2], most[3]));
    wanted += samples[j].weight * (IsSmall(area_m2, voxel_m) ? largest : Effort(area_m2, voxel_m) * SumOfLanes(sum));
  }
  return wanted;
}

// Takes away the field's error at the finer points of these samples, which are the first of scratch->points.
void CorrectDepths(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
                   const FieldWalkScratch& walk_scratch, std::span<const FinerSample> samples, float share,
                   RefineScratch* scratch) {
  const auto voxel_m = static_cast<float>(field.voxel_size_m);
  scratch->exact.Begin(field, X_GS, share, scratch->depths.data());
  for (std::uint32_t j = 0; j < samples.size(); ++j) {
    const FinerSample& sample = samples[j];
    const float* const depths = scratch->depths[j].of;
    const PointBlock& points = scratch->points[j];
    const PointBlock& block = sampled.points[walk_scratch.near_blocks[sample.near_block]];
    const bool is_small = IsSmall(block.area_m2[sample.lane], voxel_m);
    for (std::uint32_t k = 0; k < kBlock; ++k) {
      if (!(points.area_m2[k] > 0.0f) || !(ShareOfExact(depths[k]) > 0.0f)) continue;
      if (is_small) {
        scratch->exact.Add(PointOf(block, sample.lane), sample.depth_m / voxel_m, j, kBlock);
        break;
      }
      scratch->exact.Add(PointOf(points, k), depths[k], j, k);
    }
  }
  scratch->exact.End();
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
  const std::span<FinerSample> samples(scratch->samples.data(), scratch->num_samples);
  for (FinerSample& sample : samples) sample.weight *= share;
  // The samples go through in chunks, but how many exact depths are wanted has to be known of all of them. Nearly
  // always there is one chunk, or the first one says enough: then it is not done twice.
  const auto chunk_at = [&](std::size_t begin) {
    return samples.subspan(begin, std::min<std::size_t>(kMostBlocksAtOnce, samples.size() - begin));
  };
  float wanted = field.facets.blocks.empty() ? kManyDepths : 0.0f;
  std::size_t placed = samples.size();  // the chunk whose depths are at hand
  for (std::size_t begin = 0; begin < samples.size() && wanted < kManyDepths; begin += kMostBlocksAtOnce) {
    FindFineDepths(sampled, field, X_GS, walk_scratch, chunk_at(begin), scratch);
    // Before the finer points of a broad contact fade out: else they would ask for little just where they are many.
    wanted += CountWanted(sampled, voxel_m, walk_scratch, chunk_at(begin), *scratch) / share;
    placed = begin;
  }
  const float share_of_exact = std::clamp((kManyDepths - wanted) / (kManyDepths - kFewDepths), 0.0f, 1.0f);
  for (std::size_t begin = 0; begin < samples.size(); begin += kMostBlocksAtOnce) {
    const std::span<FinerSample> chunk = chunk_at(begin);
    if (placed != begin) FindFineDepths(sampled, field, X_GS, walk_scratch, chunk, scratch);
    placed = begin;
    if (share_of_exact > 0.0f) CorrectDepths(sampled, field, X_GS, walk_scratch, chunk, share_of_exact, scratch);
    for (std::uint32_t j = 0; j < chunk.size(); ++j) {
      const PointBlock& block = sampled.points[walk_scratch.near_blocks[chunk[j].near_block]];
      FindChange(block, scratch->points[j], scratch->depths[j].of, voxel_m, &chunk[j]);
    }
  }
}

}  // namespace vps
