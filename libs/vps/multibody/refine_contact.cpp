#include "vps/multibody/refine_contact.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "vps/field/brick_traits.hpp"
#include "vps/multibody/block_sums.hpp"

namespace vps {
namespace {

// How many of the samples near the surface, weighted, have their finer points looked at: all, up to `all`; where there
// are more, fewer and fewer of them down to `chosen`, evenly, each of which stands for others. It fades out from `near`
// of them on, or from `inside` of these inside, up to a third more: a contact of so many is broad.
struct Limits {
  float all, chosen, near, inside;
};
constexpr Limits kLimits{480.0f, 160.0f, 3072.0f, 720.0f};
// Of a part that has few samples for all of its surface: a contact of as many is as broad as it gets, and its rim is
// all that they see.
constexpr std::uint32_t kCoarsePart = 8192;
constexpr Limits kLimitsOfCoarsePart{1920.0f, 1920.0f, 1920.0f, 1920.0f};
// There is room for twice as many as it fades out at: those at the end of their reach weigh little.
constexpr std::uint32_t kMostNear = 8192;
// Samples count as inside in full where they are so much of SampleTree::refined_m, about the spacing, deep.
constexpr float kInside = 0.05f;
// Of those chosen so many are so in full, the others in part: none comes or goes at once.
constexpr float kInFull = 0.9f;

// Fades out from 1 at `begin` to 0 at `begin` + `width`.
float FadeOut(float value, float begin, float width) {
  return std::clamp((begin + width - value) / width, 0.0f, 1.0f);
}

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
float FindNear(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
               const FieldWalkResult& walk, const FieldWalkScratch& walk_scratch, const Limits& limits,
               RefineScratch* scratch) {
  const float most = limits.near * 4.0f / 3.0f;
  const float most_inside = limits.inside * 4.0f / 3.0f;
  if (static_cast<float>(walk.num_colliding) >= most) return 0.0f;  // each has a weight of 1
  const FieldTransform to_field(X_GS, field);
  const auto voxel_m = static_cast<float>(field.voxel_size_m);
  const auto most_m2 = static_cast<float>(sampled.refined_m * sampled.refined_m);
  const float inside_per_m = 1.0f / (kInside * static_cast<float>(sampled.refined_m));
  const bool can_be_exact = !field.facets.blocks.empty();
  float sum = 0.0f;
  float inside = 0.0f;
  float error = 0.0f;
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < walk.num_near_blocks; ++i) {
    const std::uint32_t at = walk_scratch.near_blocks[i];
    const PointBlock& block = sampled.points[at];
    const float* const depths = walk_scratch.depths(i);
    const SphereBlock& spheres = sampled.spheres[at / kBlock];
    const std::uint32_t lane = at % kBlock;
    const float slope = Spread(block, depths) * voxel_m / (2.0f * spheres.r[lane]);
    const float steep = std::min(1.0f, kSteeper * slope + kLeastSlope);
    float sum_of_block = 0.0f;
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
        if (count == kMostNear) return 0.0f;
        scratch->near[count] = {i, first + j, depth_m[j], std::min(weight[j], 1.0f)};
        sum_of_block += scratch->near[count++].weight;
        inside += std::clamp(depth_m[j] * inside_per_m, 0.0f, 1.0f);
      }
    }
    if (!(sum_of_block > 0.0f)) continue;
    sum += sum_of_block;
    if (sum >= most || inside >= most_inside) return 0.0f;
    if (!can_be_exact) continue;
    const glm::vec3 middle(spheres.x[lane], spheres.y[lane], spheres.z[lane]);
    error += sum_of_block * SurfaceErrorAt(field, to_field.ToVoxels(middle));
  }
  scratch->num_near_samples = count;
  scratch->sum_of_weights = sum;
  scratch->error = count > 0 ? error / sum : 0.0f;
  return FadeOut(sum, limits.near, limits.near / 3.0f) * FadeOut(inside, limits.inside, limits.inside / 3.0f);
}

// Of a number, in [0, 1): those of following numbers lie evenly (by the golden ratio), and so do those below a limit of
// samples that follow each other along the surface.
float Rank(std::uint32_t i) {
  return static_cast<float>(i * 2654435769U >> 8) * 0x1p-24f;
}

// Whose finer points are looked at.
void ChooseSamples(const SampleTree& sampled, const FieldWalkScratch& walk_scratch, const Limits& limits, float share,
                   RefineScratch* scratch) {
  const float sum = scratch->sum_of_weights;
  const float wanted = std::max(limits.chosen, std::min(limits.all, 3.0f * limits.all - 2.0f * sum));
  const float limit = wanted / (kInFull * sum);
  float chosen = 0.0f;
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < scratch->num_near_samples; ++i) {
    const NearSample& near = scratch->near[i];
    const std::uint32_t at = walk_scratch.near_blocks[near.near_block] * kBlock + near.lane;
    const float weight = near.weight * FadeOut(Rank(at), kInFull * limit, (1.0f - kInFull) * limit);
    if (!(weight > 0.0f)) continue;
    FinerSample& sample = scratch->samples[count++];
    sample.near_block = near.near_block;
    sample.lane = near.lane;
    sample.depth_m = near.depth_m;
    sample.weight = share * weight;
    chosen += weight;
    const auto* const fine = reinterpret_cast<const char*>(&sampled.fine[at]);
    for (std::size_t line = 0; line < sizeof(FineBlock); line += 64) __builtin_prefetch(fine + line);
  }
  scratch->num_samples = count;
  scratch->stand_for = chosen > 0.0f ? sum / chosen : 0.0f;
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

// Of four depths: how much counts as inside, or near enough for SmallContact to look there.
constexpr float kNear = 0.12f;  // voxels outside
constexpr float kNearFade = 0.12f;
F4 SharesNear(const F4& depth) {
  const F4 share = (depth + kNear) * (1.0f / kNearFade);
  return share > 0.0f ? (share < 1.0f ? share : F4{} + 1.0f) : F4{};
}

// What sixteen points that share a patch of surface evenly miss of the integral of depth, about: the share of one that
// lies at the rim of the contact is inside in part, which its middle does not tell. Over a share the depth varies by a
// quarter of what it varies over the whole, sigma; as evenly as over +-h, h = sqrt(3) sigma / 4, its positive part is
// (d + h)^2 / 4 h in the mean, (h - |d|)^2 / 4 h more than that of the middle. In voxels m^2.
float RimVolume_m2(const PointBlock& points, const float* depths) {
  F4 sum{};
  F4 sum_of_squares{};
  for (std::uint32_t k = 0; k < kBlock; k += 4) {
    const F4 depth = LoadF4(depths + k);
    sum += depth;
    sum_of_squares += depth * depth;
  }
  const float mean = SumOfLanes(sum) / kBlock;
  const float variance = SumOfLanes(sum_of_squares) / kBlock - mean * mean;
  if (!(variance > 1e-8f)) return 0.0f;
  const float h = 0.433f * std::sqrt(variance);
  F4 missing_m2{};
  for (std::uint32_t k = 0; k < kBlock; k += 4) {
    const F4 depth = LoadF4(depths + k);
    const F4 part = h - (depth < 0.0f ? -depth : depth);
    missing_m2 += (part > 0.0f ? part * part : F4{}) * LoadF4(points.area_m2 + k);
  }
  return SumOfLanes(missing_m2) / (4.0f * h);
}

void Survey(float voxel_m, std::span<const FinerSample> samples, RefineScratch* scratch) {
  for (std::uint32_t j = 0; j < samples.size(); ++j) {
    F4 near_m2{};
    F4 near{};
    F4 volume_m2{};
    for (std::uint32_t k = 0; k < kBlock; k += 4) {
      const F4 depth = LoadF4(scratch->depths[j].of + k);
      const F4 area_m2 = LoadF4(scratch->points[j].area_m2 + k);
      const F4 share = area_m2 > 0.0f ? SharesNear(depth) : F4{};
      near += share;
      near_m2 += share * area_m2;
      volume_m2 += (depth > 0.0f ? depth : F4{}) * area_m2;
    }
    scratch->near_m2 += SumOfLanes(near_m2);
    scratch->num_near += samples[j].weight * SumOfLanes(near);
    scratch->volume_m3 += SumOfLanes(volume_m2) * voxel_m;
    if (SumOfLanes(volume_m2) > 0.0f) {
      scratch->rim_m3 += RimVolume_m2(scratch->points[j], scratch->depths[j].of) * voxel_m;
    }
  }
}

// Contacts of so few finer points, and less and less up to twice as many, are right by chance only.
constexpr float kFewNear = 112.0f;
// And those of which finer points may miss so much at their rim, less and less down to half as much.
constexpr float kRim = 0.05f;
constexpr float kNone = 2.0f;  // fewer are not looked at, or less
// Mean depths, over the field's error, at which that counts, up to half as much again: so much that SmallContact is
// asked although finer points are many, and so much that it is asked for exact depths.
constexpr float kShallow = 10.5f;
constexpr float kInexact = 14.0f;
// Where finer points fade out, this fades later.
constexpr float kLateFade = 3.0f;
// Contacts of so many pieces, up to half as many again, take too long.
constexpr float kBroad = 128.0f;

void FindShares(const SampleTree& sampled, float voxel_m, float share, RefineScratch* scratch) {
  if (!(scratch->num_near > 0.0f) || sampled.pieces.pieces.empty()) return;
  const float depth = scratch->volume_m3 / (scratch->near_m2 * voxel_m);
  const auto share_of = [&](float limit) {
    const float until = limit * scratch->error;
    return until > 0.0f ? FadeOut(depth, until, 0.5f * until) : 0.0f;
  };
  const float num_pieces =
      scratch->near_m2 * static_cast<float>(static_cast<double>(sampled.pieces.pieces.size()) / sampled.area_m2);
  const float shallow = share_of(kShallow) * FadeOut(num_pieces, kBroad, 0.5f * kBroad);
  const float rough = 1.0f - FadeOut(scratch->rim_m3 / std::max(scratch->volume_m3, 1e-30f), 0.5f * kRim, 0.5f * kRim);
  const float few = std::max(rough, FadeOut(scratch->num_near, kFewNear, kFewNear));
  scratch->share_of_small =
      std::min(1.0f, kLateFade * share) * std::max(shallow, few) * std::min(1.0f, scratch->num_near / kNone);
  scratch->share_of_exact = share_of(kInexact);
}

void FindDeepestOf(const PointBlock& points, const float* depths, float voxel_m, FinerSample* sample) {
  const std::uint32_t k = FindDeepest(depths);
  sample->change = {.p_S = PointOf(points, k), .penetration_m = depths[k] * voxel_m};
}

// What the finer points at these depths change in what the sample, a point of `block`, tells.
void FindChange(const PointBlock& block, const PointBlock& points, const float* depths, float voxel_m,
                FinerSample* sample) {
  if (sample->change.penetration_m > 0.0f) SetSums(points, depths, voxel_m, &sample->change);
  if (!(sample->depth_m > 0.0f)) return;
  ContactPatch coarse;
  SetSums(block, sample->lane, sample->depth_m, &coarse);
  AddSums(coarse, -sample->weight, &sample->change);
}

// Of these samples, whose finer points are those of the last evaluation.
void FindChanges(const SampleTree& sampled, float voxel_m, const FieldWalkScratch& walk_scratch,
                 std::span<FinerSample> samples, RefineScratch* scratch) {
  for (std::uint32_t j = 0; j < samples.size(); ++j) {
    const PointBlock& block = sampled.points[walk_scratch.near_blocks[samples[j].near_block]];
    FindChange(block, scratch->points[j], scratch->depths[j].of, voxel_m, &samples[j]);
  }
}

bool FitsAtOnce(const RefineScratch& scratch) {
  return scratch.num_samples <= kMostBlocksAtOnce;
}

}  // namespace

RefineScratch::RefineScratch()
    : near(kMostNear),
      samples(kMostNear),
      points(kMostBlocksAtOnce),
      spheres(kMostBlocksAtOnce / kBlock),
      depths(kMostBlocksAtOnce) {}

void RefineContact(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
                   const FieldWalkResult& walk, const FieldWalkScratch& walk_scratch, RefineScratch* scratch) {
  scratch->num_samples = 0;
  scratch->num_near = scratch->near_m2 = scratch->volume_m3 = scratch->rim_m3 = 0.0f;
  scratch->share_of_small = scratch->share_of_exact = 0.0f;
  if (sampled.fine.empty()) return;
  const auto voxel_m = static_cast<float>(field.voxel_size_m);
  const Limits& limits = sampled.num_points <= kCoarsePart ? kLimitsOfCoarsePart : kLimits;
  const float share = FindNear(sampled, field, X_GS, walk, walk_scratch, limits, scratch);
  if (!(share > 0.0f)) return;
  ChooseSamples(sampled, walk_scratch, limits, share, scratch);
  const std::span<FinerSample> samples(scratch->samples.data(), scratch->num_samples);
  for (std::size_t begin = 0; begin < samples.size(); begin += kMostBlocksAtOnce) {
    const std::size_t count = std::min<std::size_t>(kMostBlocksAtOnce, samples.size() - begin);
    const std::span<FinerSample> chunk = samples.subspan(begin, count);
    FindFineDepths(sampled, field, X_GS, walk_scratch, chunk, scratch);
    Survey(voxel_m, chunk, scratch);
    for (std::uint32_t j = 0; j < chunk.size(); ++j) {
      FindDeepestOf(scratch->points[j], scratch->depths[j].of, voxel_m, &chunk[j]);
    }
    if (!FitsAtOnce(*scratch)) FindChanges(sampled, voxel_m, walk_scratch, chunk, scratch);
  }
  // Of all, whatever weight they have.
  const float factor = scratch->stand_for / share;
  scratch->num_near *= factor;
  scratch->near_m2 *= factor;
  scratch->volume_m3 *= factor;
  scratch->rim_m3 *= factor;
  FindShares(sampled, voxel_m, share, scratch);
}

void FindChangesOfSums(const SampleTree& sampled, const DistanceField& field, const FieldWalkScratch& walk_scratch,
                       RefineScratch* scratch) {
  if (!FitsAtOnce(*scratch)) return;
  const std::span<FinerSample> samples(scratch->samples.data(), scratch->num_samples);
  FindChanges(sampled, static_cast<float>(field.voxel_size_m), walk_scratch, samples, scratch);
}

}  // namespace vps
