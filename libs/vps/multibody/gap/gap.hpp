#pragma once

#include <algorithm>
#include <cmath>

#include "core/pose.hpp"
#include "vps/field/distance_field.hpp"
#include "vps/multibody/block_sums.hpp"
#include "vps/sampling/touch_points.hpp"
#include "vps/walk/walk_kernel.hpp"

namespace vps {

// Here lengths are in voxels of G's field, points and directions in G and its axes, unless their names say otherwise.

// From a point of S to the surface of G.
struct Gap {
  bool is_found = false;
  glm::dvec3 p{0.0};  // of S, in G, voxels
  glm::dvec3 n{0.0};  // from G to S, unit
  double height = 0.0;

  [[nodiscard]] glm::dvec3 OnG() const { return p - height * n; }
};

// The least one, and in a groove of G the one to its other face.
struct Gaps {
  Gap least;
  Gap other;
};

// The two surfaces of a query, and where S stands in G.
struct GapScene {
  const TouchPoints& S;
  const DistanceField& field;
  const core::Pose& X_GS;
  glm::mat3 R_GS;
  glm::dmat3 voxels_per_S;  // and S's origin: to G, voxels
  glm::dvec3 p_GSo;

  GapScene(const TouchPoints& places, const DistanceField& distances, const core::Pose& pose)
      : S(places),
        field(distances),
        X_GS(pose),
        R_GS(glm::mat3_cast(pose.rotation)),
        voxels_per_S(glm::mat3_cast(pose.rotation) / distances.voxel_size_m),
        p_GSo((pose.translation - distances.origin_m) / distances.voxel_size_m) {}

  [[nodiscard]] glm::vec3 PointAt(std::uint32_t point) const {  // in S, metres
    return PointOf(S.tree.points[point / kBlock], point % kBlock);
  }
  [[nodiscard]] glm::dvec3 InVoxels(const glm::vec3& p_S) const { return voxels_per_S * glm::dvec3(p_S) + p_GSo; }
  [[nodiscard]] glm::dvec3 InSample(const glm::dvec3& p) const {  // in S, metres
    return X_GS.inverse() * (p * field.voxel_size_m + field.origin_m);
  }
};

// A place gets its exact gap when it can be nearer than this by the field. What is farther does not touch: the field is
// off by no more.
constexpr double kExactWithin = static_cast<double>(kMostFieldError);
// From a point this much off the surface it is clear which face, edge or corner of G is below.
constexpr double kClear = 0.02;
// Faces and edges with less between them are along each other; likewise as a sine, squared.
constexpr double kSlope = 1e-3;
constexpr double kAlong = kSlope * kSlope;
constexpr int kMostHops = 5;

// A place of S as G sees it.
struct PlaceInG {
  TouchPlace::Kind kind = TouchPlace::Kind::kCorner;
  glm::dvec3 p{0.0};
  glm::dvec3 inward{0.0};
  glm::dvec3 along{0.0};
  double reach = 0.0;  // of the patch or of the piece of edge about p
  double depth = 0.0;  // by the field

  // A point clear of the surface, back along S's own normal, from which the place is seen.
  [[nodiscard]] double back() const { return std::max(depth, 0.0) + kClear; }
};

// How far the surface can be from a place that is so deep by the field.
inline double SearchReach(double depth) {
  return std::abs(depth) + static_cast<double>(kMostFieldError);
}

// A place stands for the round surface around it, whose faces take turns within a cycle: a normal that is farther
// outside its own than from one face to the next belongs to another place.
inline double Beside_rad(const TouchPoints& S) {
  return S.turn_rad + kSlope;
}

}  // namespace vps
