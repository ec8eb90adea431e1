#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "vps/force/reduce_patches.hpp"
#include "vps/multibody/collision_world.hpp"
#include "vps/multibody/gap/choose_places.hpp"
#include "vps/surface/surface_walk.hpp"
#include "vps/walk/field_walk.hpp"

namespace vps {

// Up to kMaxSinglePoints near points enter the reduction to planes one by one; more of them block by block of sixteen
// neighbours, or in groups of 2, 4 ... neighbouring blocks, so that there are at most kMaxNearPatches of one or two
// directions. Not derived: ReducePatches takes time for each.
constexpr std::uint32_t kMaxSinglePoints = 24;
constexpr std::uint32_t kMaxNearPatches = 128;
static_assert(2 * kMaxNearPatches + SurfaceWalk::kMostParts <= kMaxPatches);

// What a query of `fast` needs of S and of G.
struct FastPair {
  const SampleTree& samples;
  const SurfaceTree& surface;
  const DistanceField& field;
  const FieldBends& bends;
  // The object whose SamplesAt(coarseness) these are. Null: it has no others.
  const CookedObject* sampled = nullptr;
  std::uint32_t coarseness = 0;
};

FastPair FastPairOf(const CookedObject& S, const CookedObject& G, const TouchMemory& memory = {});

// The penalty integral over S's surface inside G before AreaScale, about S's mesh origin, in S.
struct TouchIntegral {
  glm::dvec3 force_m3{0.0};
  glm::dvec3 moment_m4{0.0};
  double volume_m3 = 0.0;         // integral of depth
  double square_m4 = 0.0;         // integral of its square
  double error_m3 = 0.0;          // estimate of |force - the exact one|
  double share_of_samples = 0.0;  // of the samples' estimate in it; the rest is the surface's
  [[nodiscard]] bool is_contact() const { return volume_m3 > 0.0; }
};

// Memory of a query, allocated once; serves this tree and smaller ones.
struct FastPairScratch {
  explicit FastPairScratch(const SampleTree& tree) : walk(tree), patches(kMaxPatches) {}
  FieldWalkScratch walk;
  FieldWalkResult found;  // of that walk
  SurfaceWalk surface;
  std::vector<ContactPatch> patches;
  std::unique_ptr<GapScratch> gaps;  // FinishGapPair needs it
  TouchMemory* memory = nullptr;     // null: each query starts anew
  // Budget of a walk and its surface, in points; a repeated walk and a proof have it once more. 0: most_places alone.
  std::uint32_t most_points = 0;
  // Of the last query.
  TouchIntegral touch;
  bool is_cut_short = false;     // a budget ran out
  std::uint32_t points_due = 0;  // that it would have tested without a budget
  std::uint64_t places_read = 0;
};

// Of time, a place that SurfaceWalk reads takes about as much as so many points of a walk. Measured: 25 to 35 ns
// against 1.5 to 2.
constexpr std::uint32_t kPointsOfPlace = 16;

// Factor [1/m^2] from the penalty integral [m^3] to the length that a pair's stiffness [N/m] multiplies; the
// counterpart of Eq. 2:
//
//   1 / max(A_c, rho A),   A_c = (integral of d)^2 / (integral of d^2),   A: S's area.
//
// A_c is the area that carries, so the result is the depth-weighted mean depth: h for a face pressed in by h, 2/3 h for
// a ball. So a pair is never stiffer than its stiffness, however much area touches; below rho the contact has the
// modulus k / (rho A). Independent of the number of points, and without the step that Eq. 2 makes when one more point
// touches.
inline double AreaScale(double volume_m3, double square_m4, double area_m2, double rho) {
  const double carrying_m2 = square_m4 > 0.0 ? volume_m3 * volume_m3 / square_m4 : 0.0;
  const double reference_m2 = std::max(carrying_m2, rho * area_m2);
  return reference_m2 > 0.0 ? 1.0 / reference_m2 : 0.0;
}

// QueryPair's counterpart for `fast`: one pair, from poses to forces and planes. Same results and same meaning of the
// return value, but for the planes' stiffness: a modulus times area here (ReducePatches). S's samples find what is near
// G and give a first estimate (WalkField). Where that is not accurate enough, what touches is integrated over S's
// surface (SurfaceWalk), and of the two estimates the surer one counts more.
double QueryFastPair(const FastPair& parts, const core::Pose& X_WS, const core::Pose& X_GS, const PairDescription& pair,
                     double rho, FastPairScratch* scratch, PairResult* result);

// The margin of its walk: the look-ahead, but at least the radius of a usual patch, so that the samples of nearly all
// patches that can be in contact are near.
double WalkMargin_m(const SampleTree& sampled, double look_ahead_m);

// The same in parts: scratch->walk.Prepare with that margin, its chunks, scratch->found = its Finish, then this.
double FinishFastPair(const FastPair& parts, const core::Pose& X_WS, const core::Pose& X_GS,
                      const PairDescription& pair, double rho, FastPairScratch* scratch, PairResult* result);

// Its part that integrates: scratch->touch, and the result's force with its error.
void IntegrateTouch(const FastPair& parts, const core::Pose& X_WS, const core::Pose& X_GS, const PairDescription& pair,
                    double rho, FastPairScratch* scratch, PairResult* result);
// The same where nothing is near.
void ClearTouch(FastPairScratch* scratch, PairResult* result);
// The result of a pair that is apart. Returns free_m: nothing of S comes within the margin while it moves no farther.
double SetApart(double free_m, double margin_m, const SampleTree& sampled, FastPairScratch* scratch,
                PairResult* result);

}  // namespace vps
