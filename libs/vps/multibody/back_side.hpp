#pragma once

#include <span>

#include "vps/force/reduce_patches.hpp"
#include "vps/walk/field_walk.hpp"

namespace vps {

// The other view of a pair: points of G in the field of S, for features of G that slip between the points of S.
struct BackSide {
  const SampleTree* points = nullptr;    // of G
  const DistanceField* field = nullptr;  // of S
  [[nodiscard]] bool is_used() const { return points != nullptr && field != nullptr; }
};

// Is it worth looking from the other side too? When G has points closer together than half the mean spacing of S's: it
// has sharp edges (SampleSpacing) or is a small part on a large one. Goes through all points of G.
bool NeedsBackSide(const SampleTree& sampled, const SampleTree& of_field_object);

// The penalty integral, estimated from points of G. Over the surface of S inside G, with u the depth in G,
//   int u n_in dA = -int over S inside G of grad u dV   (Gauss; u is zero on the rest of the boundary)
//                 = sum over points a of G inside S of area n_out(a) t(a),
// where t is the length of the column that starts at a, runs along G's inward normal, along which u grows by one per
// length, and ends where it leaves S or where another place of G's surface becomes nearer (u stops growing). Exact for
// flat contact. On G's surface of radius R columns are taken as straight prisms, an error of t / R; material of S that
// no column reaches (behind an undercut) is missed. Moments follow, each force acting along its column.
struct BackSum {
  glm::dvec3 force_m3{0.0};   // in S
  glm::dvec3 moment_m4{0.0};  // about S's mesh origin
  double volume_m3 = 0.0;     // sum of area t
  double square_m4 = 0.0;     // sum of area t^2: what the integral of depth^2 is for S's points
  double num_effective = 0.0;
};

// How many points of equal weight tell as much: (sum w)^2 / sum w^2. Continuous where a count is not.
class EffectiveCount {
 public:
  void Add(double weight) {
    sum_ += weight;
    squares_ += weight * weight;
  }
  [[nodiscard]] double value() const { return squares_ > 0.0 ? sum_ * sum_ / squares_ : 0.0; }

 private:
  double sum_ = 0.0, squares_ = 0.0;
};

// Share of the back side in the sum of both, by their effective counts: the square of its count in the sum of squares,
// fading out from 100 to 200 points of S: a contact that S's points resolve is theirs.
double BackShare(double front_count, double back_count);

// Of the points that WalkField(points of G, field of S) found near: the first `patches.size()` in the walk's order get
// a patch each (of which the integrals must still be multiplied by the side's share), all of them are summed.
BackSum SumBackSide(const BackSide& back, const DistanceField& field, const core::Pose& X_GS,
                    const FieldWalkResult& walk, const FieldWalkScratch& scratch, double margin_m,
                    std::span<ContactPatch> patches, std::uint32_t* num_patches);

}  // namespace vps
