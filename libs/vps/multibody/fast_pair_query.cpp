#include "vps/multibody/fast_pair_query.hpp"

#include <algorithm>
#include <cmath>

#include "vps/multibody/block_sums.hpp"
#include "vps/walk/walk_memory.hpp"

namespace vps {
namespace {

struct Front {
  const SampleTree& sampled;
  const DistanceField& field;
  FieldTransform T;
};

// The gap's derivative is the field's gradient; the point's own normal is 45 degrees off at an edge.
void Place(const Front& front, const glm::vec3& p_S, float depth_m, ContactPatch* patch) {
  patch->p_S = p_S;
  patch->n_G = SampleField(front.field, front.T.ToVoxels(p_S)).gradient;
  patch->penetration_m = depth_m;
}

void Scale(float factor, ContactPatch* patch) {
  patch->force_m3 *= factor;
  patch->moment_m4 *= factor;
  patch->volume_m3 *= factor;
  patch->square_m4 *= factor;
}

// The finer samples of a walk, taken in its order.
class FinerSamples {
 public:
  FinerSamples(const RefineScratch& scratch, std::uint32_t count)
      : next_(scratch.samples.data()), end_(next_ + count) {}

  // Adds their corrections to the patch of a point, or of all points of a block; *p_S and *depth_m become the deepest
  // place and its depth if that is deeper.
  void AddTo(std::uint32_t near_block, std::uint32_t first_lane, std::uint32_t last_lane, ContactPatch* patch,
             glm::vec3* p_S, float* depth_m) {
    while (next_ < end_ && IsBefore(near_block, first_lane)) ++next_;
    for (; next_ < end_ && next_->near_block == near_block && next_->lane <= last_lane; ++next_) {
      AddSums(next_->change, 1.0f, patch);
      if (next_->weight <= 0.0f || next_->change.penetration_m <= *depth_m) continue;
      *depth_m = next_->change.penetration_m;
      *p_S = next_->change.p_S;
    }
  }

 private:
  [[nodiscard]] bool IsBefore(std::uint32_t near_block, std::uint32_t lane) const {
    return next_->near_block < near_block || (next_->near_block == near_block && next_->lane < lane);
  }
  const FinerSample* next_;
  const FinerSample* end_;
};

// Patches of the points that a walk found near.
std::uint32_t MakePatches(const Front& front, const FieldWalkResult& walk, const FieldWalkScratch& scratch,
                          double look_ahead_m, FinerSamples finer, float weight, ContactPatch* patches) {
  const auto voxel_m = static_cast<float>(front.field.voxel_size_m);
  const auto least_m = static_cast<float>(-look_ahead_m);
  const bool takes_all = walk.num_near <= kMaxSinglePoints;
  std::uint32_t mask = 0;
  while (walk.num_near_blocks / (mask + 1) > kMaxFastContacts) mask = 2 * mask + 1;
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < walk.num_near_blocks; ++i) {
    const std::uint32_t at = scratch.near_blocks[i];
    const bool is_deepest = at == walk.deepest_point / kBlock;
    if (!takes_all && ((at & mask) != 0 || count >= 2 * kMaxFastContacts) && !is_deepest) continue;
    const PointBlock& block = front.sampled.points[at];
    const float* const depths = scratch.depths(i);
    const std::uint32_t deepest = is_deepest ? walk.deepest_point % kBlock : FindDeepest(depths);
    const std::uint32_t begin = takes_all ? 0 : deepest;
    const std::uint32_t end = takes_all ? kBlock : deepest + 1;
    for (std::uint32_t k = begin; k < end; ++k) {
      ContactPatch& patch = patches[count];
      if (takes_all) {
        SetSums(block, k, depths[k] * voxel_m, &patch);
      } else {
        SetSums(block, depths, voxel_m, &patch);
      }
      glm::vec3 p_S = PointOf(block, k);
      float depth_m = depths[k] * voxel_m;
      finer.AddTo(i, takes_all ? k : 0, takes_all ? k : kBlock - 1, &patch, &p_S, &depth_m);
      if (depth_m < least_m) continue;
      Place(front, p_S, depth_m, &patch);
      Scale(weight, &patch);
      ++count;
    }
  }
  return count;
}

// Share of a contact that SmallContact integrates, which has run then; 0: it was not needed or gave up.
double IntegrateIfSmall(const SampleTree& finest, const DistanceField& field, const core::Pose& X_GS,
                        FastPairScratch* scratch) {
  const RefineScratch& refine = scratch->refine;
  if (!(refine.share_of_small > 0.0f)) return 0.0;
  const double spacing_m = std::sqrt(finest.area_m2 / finest.num_points);
  const bool is_integrated = scratch->small.Integrate(
      finest.pieces, field, X_GS, {spacing_m, static_cast<double>(refine.near_m2), refine.share_of_exact});
  return is_integrated ? static_cast<double>(refine.share_of_small) : 0.0;
}

// Returns free_m: nothing of S comes within the margin while it moves no farther.
double SetApart(double free_m, double margin_m, const SampleTree& sampled, FastPairScratch* scratch,
                PairResult* result) {
  scratch->force_m3 = scratch->moment_m4 = glm::dvec3(0.0);
  result->is_in_contact = false;
  result->f_So_S = {};
  result->F_So_W = {};
  result->planes.clear();
  result->signed_distance_m = std::max(0.0, margin_m + free_m - sampled.reach_m);
  return free_m;
}

}  // namespace

double WalkMargin_m(const SampleTree& sampled, double look_ahead_m) {
  return sampled.fine.empty() ? look_ahead_m : std::max(look_ahead_m, sampled.refined_m);
}

double QueryFastPair(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_WS,
                     const core::Pose& X_GS, const PairDescription& pair, double rho, FastPairScratch* scratch,
                     PairResult* result) {
  const double margin_m = WalkMargin_m(sampled, pair.look_ahead_m);
  if (FieldWalkMemory* const memory = scratch->walk.memory; memory != nullptr) {
    if (const double free_m = memory->RemainingFreeDistance_m(sampled, field, X_GS, margin_m); free_m > 0.0) {
      result->counters = {};
      return SetApart(free_m, margin_m, sampled, scratch, result);
    }
  }
  std::uint32_t num_chunks =
      scratch->levels.Begin(sampled, field, X_GS, margin_m, BestInstructionSet(), &scratch->walk);
  do {
    for (std::uint32_t i = 0; i < num_chunks; ++i) EvaluateChunk(&scratch->walk, i);
    num_chunks = scratch->levels.Next();
  } while (num_chunks > 0);
  return FinishFastPair(sampled, field, X_WS, X_GS, pair, rho, scratch, result);
}

double FinishFastPair(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_WS,
                      const core::Pose& X_GS, const PairDescription& pair, double rho, FastPairScratch* scratch,
                      PairResult* result) {
  const FieldWalkResult& walk = scratch->levels.result();
  const SampleTree& finest = scratch->levels.finest();
  result->counters = {walk.spheres_tested, walk.points_tested, walk.num_colliding};
  if (walk.num_near == 0) {
    return SetApart(walk.free_distance_m, WalkMargin_m(sampled, pair.look_ahead_m), sampled, scratch, result);
  }
  scratch->force_m3 = walk.force_m3;
  scratch->moment_m4 = walk.moment_m4;
  RefineContact(finest, field, X_GS, walk, scratch->walk, &scratch->refine);
  const std::uint32_t num_finer = scratch->refine.num_samples;
  const double small_share = IntegrateIfSmall(finest, field, X_GS, scratch);
  double volume_m3 = walk.volume_m3;
  double square_m4 = walk.square_m4;
  double deepest_m = walk.deepest_m;
  std::uint32_t deepest_point = walk.deepest_point;
  glm::vec3 deepest_p_S = PointOf(finest.points[deepest_point / kBlock], deepest_point % kBlock);
  result->counters.points_tested += std::uint64_t{num_finer} * kBlock;
  const auto num_represented = static_cast<double>(scratch->refine.num_represented);
  for (std::uint32_t j = 0; j < num_finer; ++j) {
    const FinerSample& finer = scratch->refine.samples[j];
    scratch->force_m3 += num_represented * glm::dvec3(finer.change.force_m3);
    scratch->moment_m4 += num_represented * glm::dvec3(finer.change.moment_m4);
    volume_m3 += num_represented * static_cast<double>(finer.change.volume_m3);
    square_m4 += num_represented * static_cast<double>(finer.change.square_m4);
    if (!(finer.weight > 0.0f)) continue;
    if (finer.change.penetration_m > 0.0f && finer.depth_m <= 0.0f) ++result->counters.points_colliding;
    if (static_cast<double>(finer.change.penetration_m) <= deepest_m) continue;
    deepest_m = static_cast<double>(finer.change.penetration_m);
    deepest_point = scratch->walk.near_blocks[finer.near_block] * kBlock + finer.lane;
    deepest_p_S = finer.change.p_S;
  }
  const PointBlock& block = finest.points[deepest_point / kBlock];
  const std::uint32_t lane = deepest_point % kBlock;
  glm::dvec3 n_S(block.nx[lane], block.ny[lane], block.nz[lane]);
  if (small_share > 0.0) {
    const SmallContact::Sums& small = scratch->small.sums();
    const auto mix = [&](auto* of, const auto& with) { *of = (1.0 - small_share) * *of + small_share * with; };
    mix(&scratch->force_m3, small.force_m3);
    mix(&scratch->moment_m4, small.moment_m4);
    mix(&volume_m3, small.volume_m3);
    mix(&square_m4, small.square_m4);
    result->counters.points_tested += small.places_tested;
    if (small.places_inside > 0 && result->counters.points_colliding == 0) result->counters.points_colliding = 1;
    // A sample inside by the field counts as contact even where its exact depth is just outside.
    if (small.deepest_m > 0.0f) {
      deepest_m = std::max(deepest_m, 0.0);
      const auto small_m = static_cast<double>(small.deepest_m);
      // Samples lie on sharp edges, where the deepest place may be.
      const double sample_m =
          small_m < deepest_m
              ? scratch->small.ComputeExactDepth_m(field, X_GS, deepest_p_S, deepest_m, scratch->refine.share_of_exact)
              : 0.0;
      mix(&deepest_m, std::max(small_m, sample_m));
      if (!(sample_m > small_m)) {
        deepest_p_S = small.deepest_p_S;
        n_S = small.deepest_n_S;
      }
    }
  }
  result->is_in_contact = result->counters.points_colliding > 0;
  result->signed_distance_m = -deepest_m;
  result->deepest_p_S = deepest_p_S;
  result->deepest_n_S = n_S / std::max(glm::length(n_S), 1e-12);

  const double scale = AreaScale(volume_m3, square_m4, sampled.area_m2, rho);
  result->f_So_S = scale * PenetrationSum{scratch->force_m3, scratch->moment_m4};
  result->F_So_W = PenaltyWrench(pair.stiffness_N_per_m, Rotate(X_WS, result->f_So_S));
  const Front front{finest, field, FieldTransform(X_GS, field)};
  std::uint32_t num_patches =
      MakePatches(front, walk, scratch->walk, pair.look_ahead_m, FinerSamples(scratch->refine, num_finer),
                  static_cast<float>(1.0 - small_share), scratch->patches.data());
  if (small_share > 0.0) {
    for (const ContactPatch& part : scratch->small.patches()) {
      ContactPatch& patch = scratch->patches[num_patches++] = part;
      Place(front, part.p_S, part.penetration_m, &patch);
      Scale(static_cast<float>(small_share), &patch);
    }
  }
  const ContactLoad load{scratch->force_m3, scratch->moment_m4, volume_m3, scale * pair.stiffness_N_per_m};
  ReducePatches({scratch->patches.data(), num_patches}, X_GS, load, pair.stiffness_N_per_m, pair.look_ahead_m,
                2.0 * field.voxel_size_m, &result->planes, 0.25 * field.voxel_size_m);
  return 0.0;
}

}  // namespace vps
