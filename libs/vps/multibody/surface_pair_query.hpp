#pragma once

#include <vector>

#include "vps/force/reduce_patches.hpp"
#include "vps/multibody/collision_world.hpp"
#include "vps/surface/surface_walk.hpp"
#include "vps/walk/field_walk.hpp"

namespace vps {

// Near samples enter the reduction to planes one by one while they are few (kMaxSinglePoints), else block by block, at
// most about so many blocks: all, every second, fourth ..., always the same ones. Not derived: ReducePatches takes time
// for each.
constexpr std::uint32_t kMostNearPatches = 128;
static_assert(2 * kMostNearPatches + SurfaceWalk::kMostParts <= kMaxPatches);

// What such a query needs of S and of G.
struct SurfacePair {
  const SampleTree& samples;
  const SurfaceTree& surface;
  const DistanceField& field;
  const FieldBends& bends;
};
SurfacePair SurfacePairOf(const CookedObject& S, const CookedObject& G);

// Of a pair from query to query.
struct TouchMemory {
  SurfaceMemory touch;
  // While nothing touches: no place of S has to be read before one has moved by apart_m since the pose X_GS.
  SurfaceMemory apart;  // of the queries that prove it
  core::Pose X_GS;
  double apart_m = 0.0;
  double offset_m = 1e9;  // to be tried next
  int queries_to_wait = 0;
};

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

// Memory of a query, allocated once; serves these trees and smaller ones.
struct SurfacePairScratch {
  explicit SurfacePairScratch(const SampleTree& tree) : walk(tree), patches(kMaxPatches) {}
  FieldWalkScratch walk;
  FieldWalkResult found;  // of that walk
  SurfaceWalk surface;
  std::vector<ContactPatch> patches;
  TouchMemory* memory = nullptr;  // null: each query starts anew
  std::uint32_t most_points = 0;  // budget of the whole query, in points of the walk; 0: the pair's most_places alone
  // Of the last query.
  TouchIntegral touch;
  bool is_cut_short = false;     // a budget ran out
  std::uint32_t points_due = 0;  // that it would have tested without a budget
};

// Of time, a place that SurfaceWalk reads takes about as much as so many points of a walk. Measured: 25 to 35 ns
// against 1.5 to 2.
constexpr std::uint32_t kPointsOfPlace = 16;

// QueryFastPair's counterpart for a pair with an accuracy. S's samples find what is near G (WalkField); what touches is
// integrated over S's surface to that accuracy (SurfaceWalk). Where its budget does not suffice, the samples' own
// estimate counts by as much as it is surer.
double QuerySurfacePair(const SurfacePair& parts, const core::Pose& X_WS, const core::Pose& X_GS,
                        const PairDescription& pair, double rho, SurfacePairScratch* scratch, PairResult* result);

// The margin of its walk: the look-ahead, but at least so much that every sample is near whose patch can be in contact.
double MarginOfSamples_m(const SampleTree& samples, double look_ahead_m);

// The same in parts: PrepareWalk with that margin, its chunks, scratch->found = FinishWalk, then this.
double FinishSurfacePair(const SurfacePair& parts, const core::Pose& X_WS, const core::Pose& X_GS,
                         const PairDescription& pair, double rho, SurfacePairScratch* scratch, PairResult* result);

}  // namespace vps
