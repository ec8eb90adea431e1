#pragma once

#include <algorithm>
#include <vector>

#include "vps/force/reduce_patches.hpp"
#include "vps/multibody/collision_world.hpp"
#include "vps/multibody/refine_contact.hpp"
#include "vps/multibody/small_contact.hpp"
#include "vps/walk/field_walk.hpp"
#include "vps/walk/level_walk.hpp"

namespace vps {

// Up to kMaxSinglePoints near points enter the reduction to planes one by one; more of them block by block of sixteen
// neighbours, at most about kMaxFastContacts blocks: all, every second, fourth ..., always the same ones. Not derived:
// ReducePatches takes time for each.
constexpr std::uint32_t kMaxSinglePoints = 24;
constexpr std::uint32_t kMaxFastContacts = 128;

// Memory of a query, allocated once; serves these trees and smaller ones.
struct FastPairScratch {
  explicit FastPairScratch(const SampleTree& tree) : walk(tree), patches(kMaxPatches) {}
  FieldWalkScratch walk;
  LevelWalk levels;
  RefineScratch refine;
  SmallContact small;
  std::vector<ContactPatch> patches;
  // Of the last query: the penalty integral over S's surface inside G before AreaScale, and its moment about S's mesh
  // origin, in S.
  glm::dvec3 force_m3{0.0};
  glm::dvec3 moment_m4{0.0};
};

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
// return value, but for the planes' stiffness: a modulus times area here (ReducePatches). Small contacts are refined
// (RefineContact, SmallContact).
double QueryFastPair(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_WS,
                     const core::Pose& X_GS, const PairDescription& pair, double rho, FastPairScratch* scratch,
                     PairResult* result);

// The margin of its walk: the look-ahead, but at least so much that every sample is near whose patch can be in contact.
double WalkMargin_m(const SampleTree& sampled, double look_ahead_m);

// The same in parts: scratch->levels.Begin with that margin, then Next until it is 0, each after all of its chunks,
// then this.
double FinishFastPair(const SampleTree& sampled, const DistanceField& field, const core::Pose& X_WS,
                      const core::Pose& X_GS, const PairDescription& pair, double rho, FastPairScratch* scratch,
                      PairResult* result);

}  // namespace vps
