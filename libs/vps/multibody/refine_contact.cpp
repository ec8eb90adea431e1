#include "vps/multibody/refine_contact.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "vps/field/brick_traits.hpp"
#include "vps/multibody/block_sums.hpp"

namespace vps {
namespace {

// Numbers of samples near the surface (sums of weights) that decide how many of them are refined: all, up to `all`;
// with more, fewer and fewer of them down to `chosen`, evenly, each of which represents others. Refinement fades out
// from `near` on, or from `inside` of them inside, over a third more: such a contact is broad. Tables of decision 9
// ("up to 640 samples", "some of many") and decision 16.
struct Limits {
  float all, chosen, near, inside;
};
constexpr Limits kLimits{480.0f, 160.0f, 6144.0f, 720.0f};
// Of a part with few samples in all: its contacts have no more, and the error is at their rim. All are refined until
// refinement has faded out. Decision 9 ("which samples are near"), doubled in decision 16.
constexpr std::uint32_t kCoarsePart = 8192;
constexpr Limits kLimitsOfCoarsePart{2560.0f, 1920.0f, 1920.0f, 1920.0f};
// Memory, not derived: samples at the end of their reach have small weights, so that there are more than `near`.
constexpr std::uint32_t kMostNearBlocks = 2048;
constexpr std::uint32_t kMostSamples = 8192;
// Depth at which a sample counts fully as inside, as a share of SampleTree::refined_m (about the spacing). Not derived:
// makes the number of samples inside continuous.
constexpr float kInside = 0.05f;
// Share of the chosen samples with full weight; the others have part of it, so that the choice is continuous. Not
// derived.
constexpr float kInFull = 0.9f;

// Fades out from 1 at `begin` to 0 at `begin` + `width`.
float FadeOut(float value, float begin, float width) {
  return std::clamp((begin + width - value) / width, 0.0f, 1.0f);
}

// Samples along sharp edges have smaller areas than others (SampleSpacing): below kEdgeArea of the mean a sample counts
// as one, above kPlainArea as plain (decision 9, "some of many").
constexpr float kEdgeArea = 0.5f;
constexpr float kPlainArea = 0.75f;

// Bound of the depth's slope within a patch: kSteeper times that within the block of samples, plus kLeastSlope.
// Decision 9
// ("which samples are near"); the second is not derived.
constexpr float kSteeper = 3.0f;
constexpr float kLeastSlope = 0.02f;

// Of the depths of a block's points.
struct DepthRange {
  float least, most;
};

DepthRange RangeOf(const PointBlock& block, const float* depths) {
  F4 least = F4{} + 1e30f;
  F4 most = F4{} - 1e30f;
  for (std::uint32_t k = 0; k < kBlock; k += 4) {
    const F4 depth = LoadF4(depths + k);
    const I4 is_point = LoadF4(block.area_m2 + k) > 0.0f;
    const F4 low = is_point ? depth : least;
    const F4 high = is_point ? depth : most;
    least = low < least ? low : least;
    most = high > most ? high : most;
  }
  return {std::min(std::min(least[0], least[1]), std::min(least[2], least[3])),
          std::max(std::max(most[0], most[1]), std::max(most[2], most[3]))};
}

F4 UpToOne(const F4& lanes) {
  return lanes > 0.0f ? (lanes < 1.0f ? lanes : F4{} + 1.0f) : F4{};
}

// Weight in [0, 1] of four points with these depths as near the surface: from kNear outside on, full kNearFade further
// in. These are the places that SmallContact would test (decision 16).
constexpr float kNear = 0.12f;  // voxels
constexpr float kNearFade = 0.12f;
F4 SharesNear(const F4& depth, float outside = kNear) {
  return UpToOne((depth + outside) * (1.0f / kNearFade));
}

// Sum of the weights of samples, and the number of them inside.
struct NearSum {
  float weight, inside;
};

// Weights of a block's samples: 0 where the depth d < -r, with r = steep * (radius of the patch) the reach of the patch
// towards G, 1 from d = -r / sqrt(2) on,
//   weight = clamp(2 (r^2 - d^2) / r^2, 0, 1)   for d < 0.
NearSum WeighSamples(const PointBlock& block, const float* depths, float voxel_m, const SampleTree& sampled,
                     float steep, float* weights) {
  const auto most_m2 = static_cast<float>(sampled.refined_m * sampled.refined_m);
  const float inside_per_m = 1.0f / (kInside * static_cast<float>(sampled.refined_m));
  F4 sum{};
  F4 sum_inside{};
  for (std::uint32_t k = 0; k < kBlock; k += 4) {
    const F4 depth_m = LoadF4(depths + k) * voxel_m;
    const F4 outside_m = depth_m < 0.0f ? depth_m : F4{};
    const F4 patch_m2 = LoadF4(block.area_m2 + k) * (kPatchReach * kPatchReach);
    const F4 reach_m2 = (patch_m2 < most_m2 ? patch_m2 : F4{} + most_m2) * (steep * steep);
    const F4 near = reach_m2 - outside_m * outside_m;
    const F4 weight = near > 0.0f ? UpToOne(2.0f * near / reach_m2) : F4{};
    StoreF4(weights + k, weight);
    sum += weight;
    sum_inside += near > 0.0f ? UpToOne(depth_m * inside_per_m) : F4{};
  }
  return {SumOfLanes(sum), SumOfLanes(sum_inside)};
}

// Number of a block's samples that come near without being refined by these weights. The limit is twice that of finer
// points, so that they count before the first finer point of another sample does.
constexpr float kNearUnrefined = kNear + kNearFade;
float CountUnrefined(const PointBlock& block, const float* depths, const float* weights) {
  F4 sum{};
  for (std::uint32_t k = 0; k < kBlock; k += 4) {
    const F4 left_out = SharesNear(LoadF4(depths + k), kNearUnrefined) * (1.0f - LoadF4(weights + k));
    sum += LoadF4(block.area_m2 + k) > 0.0f ? left_out : F4{};
  }
  return SumOfLanes(sum);
}

// Finds samples that may be inside G: those no farther outside than their patch reaches towards G. The reach is the
// patch's radius times the slope of the depth, estimated from the samples of its block: in a conforming contact the
// whole free side is nearer than its samples are to each other. Returns the weight of refinement, in [0, 1].
float FindNear(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
               const FieldWalkResult& walk, const FieldWalkScratch& walk_scratch, const Limits& limits,
               RefineScratch* scratch) {
  const float most = limits.near * 4.0f / 3.0f;
  const float most_inside = limits.inside * 4.0f / 3.0f;
  if (static_cast<float>(walk.num_colliding) >= most) return 0.0f;  // each has a weight of 1
  const FieldTransform to_field(X_GS, field);
  const auto voxel_m = static_cast<float>(field.voxel_size_m);
  const bool can_be_exact = !field.facets.blocks.empty();
  float sum = 0.0f;
  float inside = 0.0f;
  float unrefined = 0.0f;
  float error = 0.0f;
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < walk.num_near_blocks; ++i) {
    const std::uint32_t at = walk_scratch.near_blocks[i];
    const PointBlock& block = sampled.points[at];
    const float* const depths = walk_scratch.depths(i);
    const SphereBlock& spheres = sampled.spheres[at / kBlock];
    const std::uint32_t lane = at % kBlock;
    const DepthRange range = RangeOf(block, depths);
    const float slope = (range.most - range.least) * voxel_m / (2.0f * spheres.r[lane]);
    const float steep = std::min(1.0f, kSteeper * slope + kLeastSlope);
    if (count == kMostNearBlocks) return 0.0f;
    NearSamples& near = scratch->near[count];
    near.near_block = i;
    const NearSum of_block = WeighSamples(block, depths, voxel_m, sampled, steep, near.weights);
    if (range.most > -kNearUnrefined) unrefined += CountUnrefined(block, depths, near.weights);
    if (!(of_block.weight > 0.0f)) continue;
    ++count;
    sum += of_block.weight;
    inside += of_block.inside;
    if (sum >= most || inside >= most_inside) return 0.0f;
    if (!can_be_exact) continue;
    const glm::vec3 middle(spheres.x[lane], spheres.y[lane], spheres.z[lane]);
    error += of_block.weight * SurfaceErrorAt(field, to_field.ToVoxels(middle));
  }
  scratch->num_near_blocks = count;
  scratch->num_unrefined = unrefined;
  scratch->sum_of_weights = sum;
  scratch->error = count > 0 ? error / sum : 0.0f;
  return FadeOut(sum, limits.near, limits.near / 3.0f) * FadeOut(inside, limits.inside, limits.inside / 3.0f);
}

// Low-discrepancy ranks in [0, 1) of four consecutive numbers (multiples of the golden ratio): samples with ranks below
// a limit are evenly spread along the surface.
F4 Ranks(std::uint32_t first) {
  using U4 = std::uint32_t __attribute__((vector_size(16)));
  const U4 i = U4{0, 1, 2, 3} + first;
  return __builtin_convertvector(reinterpret_cast<I4>(i * 2654435769U >> 8), F4) * 0x1p-24f;
}

// Chooses the samples to refine and the share of their correction that is applied. Where they represent others the
// share of plain samples falls to 0: their errors are random and average out better over all samples than over some
// with finer points. Samples along a sharp edge lie in rows, and a whole row may miss the edge's contact. False: too
// many.
bool ChooseSamples(const SampleTree& sampled, const FieldWalkScratch& walk_scratch, float voxel_m, const Limits& limits,
                   float share, RefineScratch* scratch) {
  const float sum = scratch->sum_of_weights;
  const float wanted = std::max(limits.chosen, std::min(limits.all, 3.0f * limits.all - 2.0f * sum));
  const float limit = wanted / (kInFull * sum);
  const float per_rank = 1.0f / ((1.0f - kInFull) * limit);
  const float plain = FadeOut(sum, limits.all, 0.5f * (limits.all - limits.chosen));
  const auto per_m2 = static_cast<float>(sampled.num_points / (sampled.area_m2 * (kPlainArea - kEdgeArea)));
  float chosen = 0.0f;
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < scratch->num_near_blocks; ++i) {
    const NearSamples& near = scratch->near[i];
    const std::uint32_t at = walk_scratch.near_blocks[near.near_block];
    const PointBlock& block = sampled.points[at];
    const std::uint32_t first = at * kBlock;
    for (std::uint32_t k = 0; k < kBlock; k += 4) {
      const F4 weight = LoadF4(near.weights + k) * UpToOne((limit - Ranks(first + k)) * per_rank);
      const I4 is_chosen = weight > 0.0f;
      if ((is_chosen[0] | is_chosen[1] | is_chosen[2] | is_chosen[3]) == 0) continue;
      for (std::uint32_t j = 0; j < 4; ++j) {
        if (is_chosen[j] == 0) continue;
        if (count == kMostSamples) return false;
        FinerSample& sample = scratch->samples[count++];
        sample.near_block = near.near_block;
        sample.lane = k + j;
        sample.depth_m = walk_scratch.depths(near.near_block)[k + j] * voxel_m;
        sample.weight = share * weight[j];
        const float along_edge = kPlainArea / (kPlainArea - kEdgeArea) - per_m2 * block.area_m2[k + j];
        sample.applied = std::max(plain, std::clamp(along_edge, 0.0f, 1.0f));
        chosen += weight[j];
        const auto* const fine = reinterpret_cast<const char*>(&sampled.fine[first + k + j]);
        for (std::size_t line = 0; line < sizeof(FineBlock); line += 64) __builtin_prefetch(fine + line);
      }
    }
  }
  scratch->num_samples = count;
  scratch->num_represented = chosen > 0.0f ? sum / chosen : 0.0f;
  return true;
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

// Estimate of the quadrature error of sixteen points at the rim of a contact [voxels m^2]: the share of surface of a
// point at the rim is inside in part. The depth d has the standard deviation sigma over the patch and a quarter of it
// over a share; uniform over d +- h with h = sqrt(3) sigma / 4, its positive part has the mean (d + h)^2 / 4 h, which
// is
//
//   (h - |d|)^2 / 4 h   more than max(d, 0),  |d| < h.
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

void AddEstimates(float voxel_m, std::span<const FinerSample> samples, RefineScratch* scratch) {
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

// SmallContact is used for contacts of few finer points: fully below kFewNear, fading out at twice as many (decision
// 12, table; decision 15).
constexpr float kFewNear = 112.0f;
// And where the rim error of finer points exceeds kRim of the integral, fading out down to half of that (decision 16).
constexpr float kRim = 0.05f;
constexpr float kNone = 2.0f;  // it fades in between no finer point near and two (decision 15)
// Mean depth over the field's error below which the field's error counts, fading out at half as much again: kShallow
// for the use of SmallContact although finer points are many, kInexact for exact depths in it (decision 16).
constexpr float kShallow = 10.5f;
constexpr float kInexact = 14.0f;
// It is not used where so many samples, fading up to twice as many, come near without being refined: a face along G's,
// too wide to be cut into pieces (decision 9, "faces that come").
constexpr float kManyUnrefined = 512.0f;
// It fades out later than finer points do. Not derived.
constexpr float kLateFade = 3.0f;
// Contacts of so many pieces, fading up to half as many again, take too long (decision 16).
constexpr float kBroad = 128.0f;

void ComputeShares(const SampleTree& sampled, float voxel_m, float share, RefineScratch* scratch) {
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
  scratch->share_of_small = std::min(1.0f, kLateFade * share) * std::max(shallow, few) *
                            std::min(1.0f, scratch->num_near / kNone) *
                            FadeOut(scratch->num_unrefined, kManyUnrefined, kManyUnrefined);
  scratch->share_of_exact = share_of(kInexact);
}

void FindDeepestOf(const PointBlock& points, const float* depths, float voxel_m, FinerSample* sample) {
  const std::uint32_t k = FindDeepest(depths);
  sample->change = {.p_S = PointOf(points, k), .penetration_m = depths[k] * voxel_m};
}

// Correction of a sample, a point of `block`, by its finer points at these depths:
//   change = applied * (sums over finer points - weight * sums of the sample).
void FindChange(const PointBlock& block, const PointBlock& points, const float* depths, float voxel_m,
                FinerSample* sample) {
  if (!(sample->applied > 0.0f)) return;
  ContactPatch fine;
  ContactPatch coarse;
  if (sample->change.penetration_m > 0.0f) SetSums(points, depths, voxel_m, &fine);
  if (sample->depth_m > 0.0f) SetSums(block, sample->lane, sample->depth_m, &coarse);
  AddSums(coarse, -sample->weight, &fine);
  AddSums(fine, sample->applied, &sample->change);
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
    : near(kMostNearBlocks),
      samples(kMostSamples),
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
  if (!ChooseSamples(sampled, walk_scratch, voxel_m, limits, share, scratch)) return;
  const std::span<FinerSample> samples(scratch->samples.data(), scratch->num_samples);
  for (std::size_t begin = 0; begin < samples.size(); begin += kMostBlocksAtOnce) {
    const std::size_t count = std::min<std::size_t>(kMostBlocksAtOnce, samples.size() - begin);
    const std::span<FinerSample> chunk = samples.subspan(begin, count);
    FindFineDepths(sampled, field, X_GS, walk_scratch, chunk, scratch);
    AddEstimates(voxel_m, chunk, scratch);
    for (std::uint32_t j = 0; j < chunk.size(); ++j) {
      FindDeepestOf(scratch->points[j], scratch->depths[j].of, voxel_m, &chunk[j]);
    }
    if (!FitsAtOnce(*scratch)) FindChanges(sampled, voxel_m, walk_scratch, chunk, scratch);
  }
  // Estimates for all near samples, without the weight of refinement.
  const float factor = scratch->num_represented / share;
  scratch->num_near *= factor;
  scratch->near_m2 *= factor;
  scratch->volume_m3 *= factor;
  scratch->rim_m3 *= factor;
  ComputeShares(sampled, voxel_m, share, scratch);
}

void FindChangesOfSums(const SampleTree& sampled, const DistanceField& field, const FieldWalkScratch& walk_scratch,
                       RefineScratch* scratch) {
  if (!FitsAtOnce(*scratch)) return;
  const std::span<FinerSample> samples(scratch->samples.data(), scratch->num_samples);
  FindChanges(sampled, static_cast<float>(field.voxel_size_m), walk_scratch, samples, scratch);
}

}  // namespace vps
