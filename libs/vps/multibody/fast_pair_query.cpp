#include "vps/multibody/fast_pair_query.hpp"

#include <algorithm>
#include <limits>

#include "vps/field/brick_traits.hpp"
#include "vps/field/nearest_facet.hpp"
#include "vps/multibody/block_sums.hpp"
#include "vps/walk/walk_memory.hpp"

namespace vps {
namespace {

// Whatever the budget of points is. Not derived: the first passes of a contact of one place.
constexpr std::uint32_t kLeastPlaces = 256;
// What did not suffice, coarser samples, a proof that nothing touches or a surface that did not count, is tried again
// after so many queries. Not derived: each time costs up to a query.
constexpr int kQueriesToRetry = 20;
// Patches farther apart than this become several planes, voxels. Not derived.
constexpr double kWidestPlane = 2.0;

void Scale(float factor, ContactPatch* patch) {
  patch->force_m3 *= factor;
  patch->moment_m4 *= factor;
  patch->volume_m3 *= factor;
  patch->square_m4 *= factor;
}

// The deepest of the points of some blocks.
struct DeepestPlace {
  std::uint32_t block = 0;
  std::uint32_t place = 0;
  float depth = -std::numeric_limits<float>::infinity();  // voxels
  void Consider(std::uint32_t of_block, const float* depths) {
    const std::uint32_t k = FindDeepest(depths);
    if (depths[k] > depth) *this = {of_block, k, depths[k]};
  }
};

// Groups of near blocks have 2^shift neighbours of the tree each, the same ones at every pose. The least shift with at
// most kMaxNearPatches groups.
std::uint32_t ShiftOfGroups(const FieldWalkScratch& scratch, std::uint32_t num_near_blocks) {
  const auto count_groups = [&](std::uint32_t shift) {
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < num_near_blocks; ++i) {
      const bool is_first = i == 0 || scratch.near_blocks[i] >> shift != scratch.near_blocks[i - 1] >> shift;
      count += is_first ? 1 : 0;
    }
    return count;
  };
  std::uint32_t shift = 0;
  while (count_groups(shift) > kMaxNearPatches) ++shift;
  return shift;
}

// Patches of the samples that a walk found near, with `share` of their load, from patches[count] on: all of it, so that
// they add up to what the walk found. Returns the new count. Without a contact none is inside.
//
// A group makes one patch of the samples that face as its deepest does, and, where G's surface faces elsewhere there,
// one of the others: where one flank of a thread is pressed, the other's gap is what keeps a blow from going through
// it. Above the rim of a flat bottom it does not: a place of the side would stand for the rim, which touches first.
//
// A gap's derivative is the field's gradient; the point's own normal is 45 degrees off at an edge.
std::uint32_t AddNearPatches(const FastPair& parts, const core::Pose& X_GS, const FieldWalkScratch& scratch,
                             const FieldWalkResult& walk, double look_ahead_m, const TouchIntegral& touch,
                             ContactPatch* patches, std::uint32_t count) {
  const FieldTransform T(X_GS, parts.field);
  const auto voxel_m = static_cast<float>(parts.field.voxel_size_m);
  const auto share = static_cast<float>(touch.share_of_samples);
  const auto least_m = static_cast<float>(-look_ahead_m);
  const auto point_of = [&](const DeepestPlace& of) { return PointOf(parts.samples.points[of.block], of.place); };
  const auto find_n_G = [&](const DeepestPlace& of) {
    return SampleField(parts.field, T.ToVoxels(point_of(of))).gradient;
  };
  // `deepest`: where the patch's depth is.
  const auto add = [&](const DeepestPlace& deepest, const glm::vec3& n_G, const auto& put_load) {
    ContactPatch& patch = patches[count++];
    patch = {};
    if (touch.is_contact()) put_load(&patch);
    patch.p_S = point_of(deepest);
    patch.n_G = n_G;
    patch.penetration_m = voxel_m * (touch.is_contact() ? deepest.depth : std::min(deepest.depth, 0.0f));
    Scale(share, &patch);
  };
  if (walk.num_near <= kMaxSinglePoints) {
    for (std::uint32_t i = 0; i < walk.num_near_blocks; ++i) {
      const PointBlock& block = parts.samples.points[scratch.near_blocks[i]];
      for (std::uint32_t k = 0; k < kBlock; ++k) {
        const float depth = scratch.depths(i)[k];
        if (depth * voxel_m < least_m) continue;
        const DeepestPlace place{scratch.near_blocks[i], k, depth};
        add(place, find_n_G(place), [&](ContactPatch* patch) { SetSums(block, k, depth * voxel_m, patch); });
      }
    }
    return count;
  }
  const std::uint32_t shift = ShiftOfGroups(scratch, walk.num_near_blocks);
  for (std::uint32_t begin = 0, end = 0; begin < walk.num_near_blocks; begin = end) {
    DeepestPlace deepest, elsewhere;
    BlockSums sums, sums_elsewhere;
    const std::uint32_t group = scratch.near_blocks[begin] >> shift;
    for (; end < walk.num_near_blocks && scratch.near_blocks[end] >> shift == group; ++end) {
      deepest.Consider(scratch.near_blocks[end], scratch.depths(end));
    }
    const glm::vec3 n_S = NormalOf(parts.samples.points[deepest.block], deepest.place);
    for (std::uint32_t i = begin; i < end; ++i) {
      const PointBlock& block = parts.samples.points[scratch.near_blocks[i]];
      const FacingDepths depths(block, scratch.depths(i), n_S);
      sums.Add(block, depths.alike, voxel_m);
      if (!depths.has_elsewhere) continue;
      sums_elsewhere.Add(block, depths.elsewhere, voxel_m);
      elsewhere.Consider(scratch.near_blocks[i], depths.elsewhere);
    }
    const glm::vec3 n_G = find_n_G(deepest);
    const bool is_near = elsewhere.depth * voxel_m >= least_m;
    const glm::vec3 n_G_elsewhere = is_near ? find_n_G(elsewhere) : n_G;
    const bool is_split = glm::dot(n_G, n_G_elsewhere) < kAcross;
    add(deepest, n_G, [&](ContactPatch* patch) {
      sums.AddTo(patch);
      if (!is_split) sums_elsewhere.AddTo(patch);
    });
    if (is_split) add(elsewhere, n_G_elsewhere, [&](ContactPatch* patch) { sums_elsewhere.AddTo(patch); });
  }
  return count;
}

// The deepest place: of the samples, or of what was integrated.
struct Deepest {
  double depth_m = 0.0;
  glm::dvec3 p_S{0.0};
};

// Zeros where the memory proves that nothing touches.
//
// What was apart with G larger by an offset o is apart until a place of S has moved by it (distances are 1-Lipschitz).
// A share u of that is used: then a place that touches with the depth d <= u o was inside the larger G by d + (1 - u) o
// at least, so that an error e of that query hides u e as a contact. Places go with 1 / e and the way with u: per way
// any u costs the same, and one half leaves room. The offset is s times the samples' least distance; patches have to
// leave 1 - s of it, their number goes with 1 / (1 - s), and s (1 - s) is greatest at one half.
//
// An offset that fails is halved, and waits, since a query that proves nothing is lost; one that is proven is doubled.
// One as small as unfelt_m is not worth a proof: the search starts anew. While S touches nothing is tried.
const SurfaceWalk::Result& RunTouch(const FastPair& parts, const core::Pose& X_GS, const SurfaceGoal& goal,
                                    double unfelt_m, FastPairScratch* scratch) {
  constexpr double kHalf = 0.5;
  TouchMemory* const memory = scratch->memory;
  const auto run = [&](const SurfaceGoal& of, SurfaceMemory* with) -> const SurfaceWalk::Result& {
    scratch->places_read += scratch->surface.Run(parts.surface, parts.field, parts.bends, X_GS, of, with).places_read;
    return scratch->surface.result();
  };
  if (memory == nullptr) return run(goal, nullptr);
  const SampleTree& samples = parts.samples;
  if (memory->apart_m > 0.0) {
    const core::Pose& before = memory->X_GS;
    const double moved_m =
        MotionBound(before, before * samples.centre_m, X_GS, samples.centre_m, samples.radius_m + samples.reach_m);
    if (moved_m < memory->apart_m) return scratch->surface.ClearResult();
    memory->apart_m = 0.0;
  }
  const double offset_m = std::min(memory->offset_m, -kHalf * scratch->found.deepest_m);
  if (memory->queries_to_wait > 0) {
    --memory->queries_to_wait;
  } else if (offset_m > unfelt_m) {
    SurfaceGoal larger = goal;
    larger.offset_m = offset_m;
    larger.negligible_m3 /= kHalf;
    const SurfaceWalk::Result& result = run(larger, &memory->apart);
    const bool is_proven = result.is_accurate && !(result.volume_m3 > result.error_m3);
    memory->offset_m = is_proven ? offset_m / kHalf : kHalf * offset_m;
    if (is_proven) {
      memory->X_GS = X_GS;
      memory->apart_m = kHalf * offset_m;
      return result;
    }
    memory->queries_to_wait = kQueriesToRetry;
  } else {
    memory->offset_m = TouchMemory{}.offset_m;
  }
  const SurfaceWalk::Result& result = run(goal, &memory->touch);
  if (result.volume_m3 > result.error_m3) memory->queries_to_wait = kQueriesToRetry;
  return result;
}

// The field's mean error at p [voxels], a place with that depth, in voxels.
float FieldErrorAt(const FastPair& parts, const glm::vec3& p, float depth) {
  if (depth < kDeepestExact) return kMeanOfFieldError * SurfaceErrorAt(parts.field, p);
  return kMeanOfInnerError * InnerErrorAt(parts.bends, parts.field, p);
}

// An error that no hand feels: where the least area carries, the force is stiffness * integral / (rho * area).
double Negligible_m3(const FastPair& parts, const PairDescription& pair, double rho) {
  return pair.negligible_N * rho * parts.samples.area_m2 / std::max(pair.stiffness_N_per_m, 1e-9);
}

constexpr double kBetweenSamples = 0.25;  // not derived

// The error of the samples' estimate: by_cells, what they miss at the border of the contact, and what fits between
// them: the area of one times kBetweenSamples of its radius; by_field, kConfidence times the field's mean error where
// they touch, over the area that carries.
struct SampleError {
  double by_cells_m3 = 0.0;
  double by_field_m3 = 0.0;
  [[nodiscard]] double sum_m3() const { return by_cells_m3 + by_field_m3; }
};

// The field's mean error where samples touch, from about kMaxSinglePoints of the blocks: a mean over so many places is
// good to a fifth. Where none of those touches, at the deepest sample.
double MeanFieldError_m(const FastPair& parts, const core::Pose& X_GS, const FieldWalkScratch& scratch,
                        const FieldWalkResult& walk) {
  const FieldTransform T(X_GS, parts.field);
  double sum = 0.0;
  std::uint32_t count = 0;
  const auto add = [&](std::uint32_t block, std::uint32_t k, float depth) {
    const glm::vec3 p = T.ToVoxels(PointOf(parts.samples.points[block], k));
    sum += static_cast<double>(FieldErrorAt(parts, p, depth));
    ++count;
  };
  const std::uint32_t stride = 1 + walk.num_near_blocks / kMaxSinglePoints;
  for (std::uint32_t i = 0; i < walk.num_near_blocks; i += stride) {
    const float* const depths = scratch.depths(i);
    const std::uint32_t k = FindDeepest(depths);
    if (depths[k] > 0.0f) add(scratch.near_blocks[i], k, depths[k]);
  }
  const double voxel_m = parts.field.voxel_size_m;
  if (count == 0) {
    add(walk.deepest_point / kBlock, walk.deepest_point % kBlock, static_cast<float>(walk.deepest_m / voxel_m));
  }
  return voxel_m * sum / count;
}

SampleError ErrorOfSamples(const FastPair& parts, const core::Pose& X_GS, const FieldWalkScratch& scratch,
                           const FieldWalkResult& walk) {
  const SampleTree& samples = parts.samples;
  SampleError error;
  error.by_cells_m3 =
      samples.area_m2 / samples.num_points * kBetweenSamples * samples.usual_m + kConfidence * walk.missed_m3;
  if (walk.num_colliding == 0) return error;
  const double carrying_m2 = walk.square_m4 > 0.0 ? walk.volume_m3 * walk.volume_m3 / walk.square_m4 : 0.0;
  error.by_field_m3 = kConfidence * MeanFieldError_m(parts, X_GS, scratch, walk) * carrying_m2;
  return error;
}

// At most, by samples that a budget left out: the deepest were tested. It does not weigh the estimates: short of time a
// contact that is too weak is better than none.
double LeftOut_m3(const SampleTree& samples, const FieldWalkResult& walk) {
  const std::uint32_t count = walk.is_cut_short ? walk.points_due - walk.points_tested : 0;
  return count * (samples.area_m2 / samples.num_points) * std::max(walk.deepest_m, 0.0);
}

// The error that the samples' estimate may have.
double WantedOfSamples_m3(const FastPair& parts, const PairDescription& pair, double rho, const FieldWalkResult& walk) {
  return std::max(Negligible_m3(parts, pair, rho), pair.accuracy * walk.volume_m3);
}

// Chooses the samples of the next query: coarser ones, if their error is expected to be within the wanted one as well.
// Where nothing touches, the surface says so; samples give the planes.
//
// A quarter of the samples misses about five times as much: there sum e_i grows with the area of a cell, and
// sqrt(sum e_i^2) with its area and the root of its side. Planes are made of up to kMaxNearPatches blocks: samples are
// coarser only where they would still fill those. What did not suffice is tried again only after a while.
void ChooseCoarseness(const FastPair& parts, const FieldWalkResult& walk, bool is_contact, const SampleError& error,
                      double wanted_m3, TouchMemory* memory) {
  constexpr double kMissedByCoarser = 5.0;
  const bool is_enough = !is_contact || kMissedByCoarser * error.by_cells_m3 + error.by_field_m3 < wanted_m3;
  memory->coarseness = parts.coarseness;
  if (!is_contact && parts.coarseness > 0 && walk.num_near_blocks < kMaxNearPatches) {
    --memory->coarseness;
  } else if (memory->queries_to_coarser > 0) {
    --memory->queries_to_coarser;
  } else if (parts.sampled != nullptr && walk.num_near_blocks >= 4 * kMaxNearPatches && is_enough) {
    const auto coarsest = static_cast<std::uint32_t>(parts.sampled->coarser.size());
    memory->coarseness = std::min(parts.coarseness + 1, coarsest);
  }
}

// What the surface is read for; of a budget, what the walk has left.
SurfaceGoal GoalOfSurface(const FastPair& parts, const PairDescription& pair, double rho,
                          const FastPairScratch& scratch) {
  SurfaceGoal goal;
  goal.accuracy = pair.accuracy;
  goal.negligible_m3 = Negligible_m3(parts, pair, rho);
  goal.most_places = pair.most_places;
  if (scratch.most_points != 0) {
    const std::uint32_t left = scratch.most_points - std::min(scratch.most_points, scratch.found.points_tested);
    goal.most_places = std::clamp(left / kPointsOfPlace, std::min(kLeastPlaces, pair.most_places), pair.most_places);
  }
  return goal;
}

// The weight of the samples' estimate, of error f, beside the surface's, of error e: e^2 / (e^2 + f^2), and 1 of what
// they decide alone. Weights below 2 % are 0: planes come from one of the two where the other says next to nothing.
double ShareOfSamples(double e, double f, double sureness) {
  constexpr double kLeastWeight = 0.02;
  const double by_errors = e > 0.0 ? e * e / (e * e + f * f) : 0.0;
  const double weight = by_errors + sureness * (1.0 - by_errors);
  return std::clamp((weight - kLeastWeight) / (1.0 - 2.0 * kLeastWeight), 0.0, 1.0);
}

// Both estimates with those weights, `share` the samples'; so are their errors.
// What the samples miss has one sign: max(d, 0) at a sample is at most its mean over the cell (Jensen), so V is at
// least what they say, but for the field's error. What may be wrong either way is the doubt D, that and the surface's
// error. Where V is not above D there is no contact, and V counts with 1 - (D / V)^2, the estimator of James and Stein:
// nothing to speak of where D is a few percent; where no estimate is good, no force comes from what is not known.
TouchIntegral Combine(const SurfaceWalk::Result& surface, const FieldWalkResult& walk,
                      const SampleError& error_of_samples, double share) {
  const auto mix = [share](const auto& a, const auto& b) { return (1.0 - share) * a + share * b; };
  TouchIntegral touch;
  touch.share_of_samples = share;
  touch.error_m3 = mix(surface.error_m3, error_of_samples.sum_m3());
  const double volume_m3 = mix(surface.volume_m3, walk.volume_m3);
  const double doubt_m3 = mix(surface.error_m3, error_of_samples.by_field_m3);
  if (!(volume_m3 > doubt_m3)) return touch;
  const double certain = 1.0 - (doubt_m3 / volume_m3) * (doubt_m3 / volume_m3);
  touch.volume_m3 = certain * volume_m3;
  touch.force_m3 = certain * mix(surface.force_m3, walk.force_m3);
  touch.moment_m4 = certain * mix(surface.moment_m4, walk.moment_m4);
  touch.square_m4 = certain * mix(surface.square_m4, walk.square_m4);
  return touch;
}

// By G's triangles, where one is near.
double ExactDepth_m(const DistanceField& field, const core::Pose& X_GS, const Deepest& place) {
  // Farther inside the field's error is small against the depth.
  constexpr double kReach = static_cast<double>(kDeepestExact) + static_cast<double>(kMostFieldError);  // voxels
  const glm::dvec3 p = (X_GS * place.p_S - field.origin_m) / field.voxel_size_m;
  const NearestFacet nearest = FindNearestFacet(field.triangles(), p, kReach);
  return nearest.is_found ? -nearest.height * field.voxel_size_m : place.depth_m;
}

// The models of the patches overestimate their greatest depth: the field is asked again.
Deepest DeeperOf(const FastPair& parts, const core::Pose& X_GS, const SurfaceWalk::Result& surface,
                 const Deepest& sample) {
  Deepest place{0.0, glm::dvec3(surface.deepest_p_S)};
  const glm::vec3 p = FieldTransform(X_GS, parts.field).ToVoxels(surface.deepest_p_S);
  place.depth_m = -static_cast<double>(SampleField(parts.field, p).distance) * parts.field.voxel_size_m;
  return place.depth_m > sample.depth_m ? place : sample;
}

}  // namespace

FastPair FastPairOf(const CookedObject& S, const CookedObject& G, const TouchMemory& memory) {
  return {S.SamplesAt(memory.coarseness), *S.surface, *G.field, *G.bends, &S, memory.coarseness};
}

double WalkMargin_m(const SampleTree& sampled, double look_ahead_m) {
  return std::max(look_ahead_m, sampled.usual_m);
}

double QueryFastPair(const FastPair& parts, const core::Pose& X_WS, const core::Pose& X_GS, const PairDescription& pair,
                     double rho, FastPairScratch* scratch, PairResult* result) {
  const double margin_m = WalkMargin_m(parts.samples, pair.look_ahead_m);
  if (FieldWalkMemory* const memory = scratch->walk.memory; memory != nullptr) {
    if (const double free_m = memory->RemainingFreeDistance_m(parts.samples, parts.field, X_GS, margin_m);
        free_m > 0.0) {
      result->counters = {};
      return SetApart(free_m, margin_m, parts.samples, scratch, result);
    }
  }
  scratch->found = WalkField(parts.samples, parts.field, X_GS, margin_m, &scratch->walk);
  return FinishFastPair(parts, X_WS, X_GS, pair, rho, scratch, result);
}

void ClearTouch(FastPairScratch* scratch, PairResult* result) {
  scratch->touch = {};
  scratch->is_cut_short = scratch->found.is_cut_short;
  scratch->points_due = scratch->found.points_due;
  result->f_So_S = {};
  result->F_So_W = {};
  result->force_error_N = 0.0;
}

double SetApart(double free_m, double margin_m, const SampleTree& sampled, FastPairScratch* scratch,
                PairResult* result) {
  ClearTouch(scratch, result);
  if (scratch->memory != nullptr) scratch->memory->coarseness = 0;
  result->is_in_contact = false;
  result->planes.clear();
  result->signed_distance_m = std::max(0.0, margin_m + free_m - sampled.reach_m);
  return free_m;
}

void IntegrateTouch(const FastPair& parts, const core::Pose& X_WS, const core::Pose& X_GS, const PairDescription& pair,
                    double rho, FastPairScratch* scratch, PairResult* result) {
  ClearTouch(scratch, result);
  const FieldWalkResult& walk = scratch->found;
  const SurfaceGoal goal = GoalOfSurface(parts, pair, rho, *scratch);
  const SampleError error = ErrorOfSamples(parts, X_GS, scratch->walk, walk);
  const double wanted_of_samples_m3 = WantedOfSamples_m3(parts, pair, rho, walk);
  // How much the samples alone decide: wholly while their error is at most the wanted one, not at all from twice it on.
  const double sureness = std::clamp(2.0 - error.sum_m3() / wanted_of_samples_m3, 0.0, 1.0);
  // The force is at most the stiffness times the depth (AreaScale): up to this one it is negligible.
  const double unfelt_m = pair.negligible_N / std::max(pair.stiffness_N_per_m, 1e-9);
  // The surface is not read where it would not count: if it had no error, or as large a one as when it did not.
  TouchMemory* const memory = scratch->memory;
  const auto share_with = [&](double e) { return ShareOfSamples(e, error.sum_m3(), sureness); };
  const bool may_count = share_with(0.0) < 1.0;
  const bool is_hopeless =
      may_count && memory != nullptr && memory->queries_to_surface > 0 && share_with(memory->hopeless_error_m3) == 1.0;
  const bool is_read = may_count && !is_hopeless;
  scratch->places_read = 0;
  const SurfaceWalk::Result& surface =
      is_read ? RunTouch(parts, X_GS, goal, unfelt_m, scratch) : scratch->surface.ClearResult();
  const auto points = static_cast<std::uint32_t>(scratch->places_read) * kPointsOfPlace;
  result->counters.points_tested += points;
  scratch->points_due += surface.is_accurate ? points : 2 * points;  // as much again: not derived
  scratch->touch = Combine(surface, walk, error, is_read ? share_with(surface.error_m3) : 1.0);
  scratch->touch.error_m3 += scratch->touch.share_of_samples * LeftOut_m3(parts.samples, walk);
  const TouchIntegral& touch = scratch->touch;
  if (memory != nullptr) {
    ChooseCoarseness(parts, walk, touch.is_contact(), error, wanted_of_samples_m3, memory);
    if (is_hopeless) --memory->queries_to_surface;
    if (is_hopeless) --memory->queries_to_wait;
    const bool was_of_use = touch.share_of_samples < 1.0 || memory->apart_m > 0.0;
    if (is_read) memory->hopeless_error_m3 = surface.error_m3;
    if (is_read) memory->queries_to_surface = was_of_use ? 0 : kQueriesToRetry;
  }
  const double wanted_m3 = std::max(goal.negligible_m3, goal.accuracy * touch.volume_m3);
  scratch->is_cut_short |= (is_hopeless || !surface.is_accurate) && touch.error_m3 > wanted_m3;
  if (touch.share_of_samples == 1.0) scratch->surface.ClearResult();
  const double scale = AreaScale(touch.volume_m3, touch.square_m4, parts.samples.area_m2, rho);
  result->f_So_S = scale * PenetrationSum{touch.force_m3, touch.moment_m4};
  result->F_So_W = PenaltyWrench(pair.stiffness_N_per_m, Rotate(X_WS, result->f_So_S));
  result->force_error_N = pair.stiffness_N_per_m * scale * touch.error_m3;
}

double FinishFastPair(const FastPair& parts, const core::Pose& X_WS, const core::Pose& X_GS,
                      const PairDescription& pair, double rho, FastPairScratch* scratch, PairResult* result) {
  const FieldWalkResult& walk = scratch->found;
  result->counters = {walk.spheres_tested, walk.points_tested, walk.num_colliding};
  if (walk.num_near == 0) {
    return SetApart(walk.free_distance_m, WalkMargin_m(parts.samples, pair.look_ahead_m), parts.samples, scratch,
                    result);
  }
  if (parts.coarseness > 0 && walk.num_colliding > 0 &&
      ErrorOfSamples(parts, X_GS, scratch->walk, walk).sum_m3() > WantedOfSamples_m3(parts, pair, rho, walk)) {
    if (scratch->memory != nullptr) scratch->memory->queries_to_coarser = kQueriesToRetry;
    const std::uint32_t finer_by_one = parts.coarseness - 1;
    const FastPair finer = {
        parts.sampled->SamplesAt(finer_by_one), parts.surface, parts.field, parts.bends, parts.sampled, finer_by_one};
    const QueryCounters spent = result->counters;
    const double free_m = QueryFastPair(finer, X_WS, X_GS, pair, rho, scratch, result);
    result->counters.spheres_tested += spent.spheres_tested;
    result->counters.points_tested += spent.points_tested;
    return free_m;
  }
  IntegrateTouch(parts, X_WS, X_GS, pair, rho, scratch, result);
  const TouchIntegral& touch = scratch->touch;
  result->is_in_contact = touch.is_contact();
  const PointBlock& block = parts.samples.points[walk.deepest_point / kBlock];
  Deepest deepest{walk.deepest_m, PointOf(block, walk.deepest_point % kBlock)};
  ContactLoad load;
  std::uint32_t num_patches = 0;
  if (touch.is_contact()) {
    result->counters.points_colliding = std::max<std::uint64_t>(result->counters.points_colliding, 1);
    const SurfaceWalk::Result& surface = scratch->surface.result();
    if (surface.patches_inside > 0) deepest = DeeperOf(parts, X_GS, surface, deepest);
    deepest.depth_m = std::max(0.0, ExactDepth_m(parts.field, X_GS, deepest));
    const double scale = AreaScale(touch.volume_m3, touch.square_m4, parts.samples.area_m2, rho);
    load = {touch.force_m3, touch.moment_m4, touch.volume_m3, scale * pair.stiffness_N_per_m};
    for (const ContactPatch& part : scratch->surface.parts()) {
      scratch->patches[num_patches] = part;
      Scale(static_cast<float>(1.0 - touch.share_of_samples), &scratch->patches[num_patches++]);
    }
  }
  result->signed_distance_m = touch.is_contact() ? -deepest.depth_m : std::max(0.0, -deepest.depth_m);
  num_patches =
      AddNearPatches(parts, X_GS, scratch->walk, walk, pair.look_ahead_m, touch, scratch->patches.data(), num_patches);
  ReducePatches({scratch->patches.data(), num_patches}, X_GS, load, pair.stiffness_N_per_m, pair.look_ahead_m,
                kWidestPlane * parts.field.voxel_size_m, &result->planes, kHysteresis * parts.field.voxel_size_m);
  return 0.0;
}

}  // namespace vps
