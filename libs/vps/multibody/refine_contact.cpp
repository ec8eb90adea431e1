#include "vps/multibody/refine_contact.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "vps/field/brick_traits.hpp"
#include "vps/multibody/block_sums.hpp"
#include "vps/walk/walk_input.hpp"

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

// As near the surface: these are the places that SmallContact would test (decision 16).
constexpr NearRange kNear{0.12f, 1.0f / 0.12f};  // voxels
// The same of samples that come near without being refined. The limit is twice that of finer points, so that they count
// before the first finer point of another sample does.
constexpr NearRange kNearUnrefined{0.24f, 1.0f / 0.12f};
constexpr std::uint32_t kAtOnce = 32;  // near blocks that are weighed together; not derived

F4 UpToOne(const F4& lanes) {
  return lanes > 0.0f ? (lanes < 1.0f ? lanes : F4{} + 1.0f) : F4{};
}

// Finds samples that may be inside G: those no farther outside than their patch reaches towards G. The reach is the
// patch's radius times the slope of the depth, estimated from the samples of its block: in a conforming contact the
// whole free side is nearer than its samples are to each other. Returns the weight of refinement, in [0, 1].
float FindNear(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
               const FieldWalkResult& walk, const FieldWalkScratch& walk_scratch, const Limits& limits,
               const WalkKernels& kernels, RefineScratch* scratch) {
  const float most = limits.near * 4.0f / 3.0f;
  const float most_inside = limits.inside * 4.0f / 3.0f;
  if (static_cast<float>(walk.num_colliding) >= most) return 0.0f;  // each has a weight of 1
  const FieldTransform to_field(X_GS, field);
  const auto voxel_m = static_cast<float>(field.voxel_size_m);
  const bool can_be_exact = !field.facets.blocks.empty();
  WeighInput weigh{};
  weigh.points = sampled.points.data();
  weigh.spheres = sampled.spheres.data();
  weigh.near_blocks = walk_scratch.near_blocks.data();
  weigh.near_slots = walk_scratch.near_slots.data();
  weigh.near_depths = reinterpret_cast<const float(*)[kBlock]>(walk_scratch.near_depths.data());
  weigh.m_per_voxel = voxel_m;
  weigh.most_m2 = static_cast<float>(sampled.refined_m * sampled.refined_m);
  weigh.inside_per_m = 1.0f / (kInside * static_cast<float>(sampled.refined_m));
  weigh.steeper = kSteeper;
  weigh.least_slope = kLeastSlope;
  weigh.unrefined = kNearUnrefined;
  std::array<NearBlock, kAtOnce> blocks;
  float sum = 0.0f;
  float inside = 0.0f;
  float unrefined = 0.0f;
  float error = 0.0f;
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < walk.num_near_blocks; ++i) {
    if (count == kMostNearBlocks) return 0.0f;
    if (i % kAtOnce == 0) kernels.weigh(weigh, i, std::min(i + kAtOnce, walk.num_near_blocks), blocks.data());
    const NearBlock& block = blocks[i % kAtOnce];
    unrefined += block.unrefined;
    if (!(block.weight > 0.0f)) continue;
    NearSamples& near = scratch->near[count++];
    near.near_block = i;
    std::copy_n(block.weights, kBlock, near.weights);
    sum += block.weight;
    inside += block.inside;
    if (sum >= most || inside >= most_inside) return 0.0f;
    if (!can_be_exact) continue;
    const std::uint32_t at = walk_scratch.near_blocks[i];
    const SphereBlock& spheres = sampled.spheres[at / kBlock];
    const std::uint32_t lane = at % kBlock;
    const glm::vec3 middle(spheres.x[lane], spheres.y[lane], spheres.z[lane]);
    error += block.weight * SurfaceErrorAt(field, to_field.ToVoxels(middle));
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

// Looks at the finer points of these samples. Their correction of the sums is
//   change = applied * (sums over finer points - weight * sums of the sample).
void LookAt(const SampleTree& sampled, const WalkInput& field, const FieldWalkScratch& walk_scratch,
            const WalkKernels& kernels, std::span<FinerSample> samples, RefineScratch* scratch) {
  for (std::size_t j = 0; j < samples.size(); ++j) {
    const std::uint32_t at = walk_scratch.near_blocks[samples[j].near_block];
    scratch->sources[j] = {&sampled.fine[std::size_t{at} * kBlock + samples[j].lane], &sampled.points[at],
                           samples[j].lane, samples[j].weight};
  }
  const float voxel_m = field.m_per_voxel;
  RefineInput input{scratch->sources.data(), static_cast<std::uint32_t>(samples.size()), voxel_m, kNear};
  kernels.refine(field, input, scratch->found.data());
  for (std::size_t j = 0; j < samples.size(); ++j) {
    FinerSample& sample = samples[j];
    const FinePoints& found = scratch->found[j];
    scratch->near_m2 += found.near_m2;
    scratch->num_near += sample.weight * found.num_near;
    scratch->volume_m3 += found.volume_m2 * voxel_m;
    scratch->rim_m3 += found.rim_m2 * voxel_m;
    sample.change = {.p_S = {found.p[0], found.p[1], found.p[2]}, .penetration_m = found.depth * voxel_m};
    if (!(sample.applied > 0.0f)) continue;
    const FineSums& sums = found.sums;
    ContactPatch fine;
    fine.force_m3 = {sums.force_m3[0], sums.force_m3[1], sums.force_m3[2]};
    fine.moment_m4 = {sums.moment_m4[0], sums.moment_m4[1], sums.moment_m4[2]};
    fine.volume_m3 = sums.volume_m3;
    fine.square_m4 = sums.square_m4;
    ContactPatch coarse;
    if (sample.depth_m > 0.0f) SetSums(*scratch->sources[j].block, sample.lane, sample.depth_m, &coarse);
    AddSums(coarse, -sample.weight, &fine);
    AddSums(fine, sample.applied, &sample.change);
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

}  // namespace

RefineScratch::RefineScratch()
    : near(kMostNearBlocks), samples(kMostSamples), sources(kMostBlocksAtOnce), found(kMostBlocksAtOnce) {}

void RefineContact(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_GS,
                   const FieldWalkResult& walk, const FieldWalkScratch& walk_scratch, RefineScratch* scratch) {
  scratch->num_samples = 0;
  scratch->num_near = scratch->near_m2 = scratch->volume_m3 = scratch->rim_m3 = 0.0f;
  scratch->share_of_small = scratch->share_of_exact = 0.0f;
  if (sampled.fine.empty()) return;
  const auto voxel_m = static_cast<float>(field.voxel_size_m);
  const WalkKernels kernels = KernelsOf(BestInstructionSet());
  const Limits& limits = sampled.num_points <= kCoarsePart ? kLimitsOfCoarsePart : kLimits;
  const float share = FindNear(sampled, field, X_GS, walk, walk_scratch, limits, kernels, scratch);
  if (!(share > 0.0f)) return;
  if (!ChooseSamples(sampled, walk_scratch, voxel_m, limits, share, scratch)) return;
  const WalkInput input = MakeFieldInput(field, X_GS);
  const std::span<FinerSample> samples(scratch->samples.data(), scratch->num_samples);
  for (std::size_t begin = 0; begin < samples.size(); begin += kMostBlocksAtOnce) {
    const std::size_t count = std::min<std::size_t>(kMostBlocksAtOnce, samples.size() - begin);
    LookAt(sampled, input, walk_scratch, kernels, samples.subspan(begin, count), scratch);
  }
  // Estimates for all near samples, without the weight of refinement.
  const float factor = scratch->num_represented / share;
  scratch->num_near *= factor;
  scratch->near_m2 *= factor;
  scratch->volume_m3 *= factor;
  scratch->rim_m3 *= factor;
  ComputeShares(sampled, voxel_m, share, scratch);
}

}  // namespace vps
