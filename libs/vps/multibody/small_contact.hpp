#pragma once

#include <array>
#include <span>
#include <vector>

#include "vps/force/reduce_patches.hpp"
#include "vps/multibody/exact_depths.hpp"
#include "vps/sampling/surface_pieces.hpp"
#include "vps/walk/evaluate_points.hpp"

namespace vps {

// The penalty integral of a contact smaller than the samples resolve, over S's surface itself (decisions 15, 16).
// Allocated once.
//
// The pieces of S that may be inside G are halved to one size. The depth by the field is taken at sixteen places of
// each; four of them, the centroids of its quarters, get exact depths where they are near G's surface, and the
// difference is added for the whole quarter. With the weight a [m^2] of a place, depths f by the field, f0 and e by the
// field and exact at the quarter's centroid [voxels],
//
//   integral of depth = sum over places of a max(f + e - f0, 0).
//
// The many places resolve the rim of the contact, and the few correct the field, whose error varies less. The size is
// chosen so that a contact has between kFewestPlaces and twice as many centroids; between two sizes both are used and
// blended, so that force and moment are continuous.
class SmallContact {
 public:
  struct Sums {
    glm::dvec3 force_m3{0.0};
    glm::dvec3 moment_m4{0.0};
    double volume_m3 = 0.0;
    double square_m4 = 0.0;
    float deepest_m = -1e30f;
    glm::vec3 deepest_p_S{0.0f};
    glm::vec3 deepest_n_S{0.0f};  // inward
    std::uint64_t places_tested = 0;
    std::uint64_t places_inside = 0;
  };

  SmallContact();

  struct Request {
    double spacing_m = 0.0;    // of S's samples
    double near_m2 = 0.0;      // estimate of S's surface inside G or near it: RefineScratch::near_m2
    float exact_share = 1.0f;  // weight of exact depths in e against f0; 0 takes half the time
  };
  // False: more pieces may be inside than there is room for, and there is no result. X_GS: pose of S in G; sums about
  // S's mesh origin, in S.
  bool Integrate(const SurfacePieces& S, const DistanceField& field, const core::Pose& X_GS, const Request& request);
  // The depth at p_S [m], corrected from the field's depth_m towards the exact one with the weight exact_share.
  double ComputeExactDepth_m(const DistanceField& field, const core::Pose& X_GS, const glm::vec3& p_S, double depth_m,
                             float exact_share);
  // Of the last call of Integrate that returned true.
  [[nodiscard]] const Sums& sums() const { return sums_; }
  // In at most kMostPatches parts.
  [[nodiscard]] std::span<const ContactPatch> patches() const { return {patches_.data(), num_patches_}; }
  static constexpr std::uint32_t kMostPatches = 64;

  // Triangles, coordinate by coordinate: those of corner c begin at [3 c]. m.
  struct Triangles {
    static constexpr std::uint32_t kMost = 2048;  // decision 15; not derived
    std::array<std::vector<float>, 9> of;
    std::uint32_t count = 0;

    Triangles();
  };

 private:
  bool FindCandidates(const SurfacePieces& S, SphereSieve* sieve);
  void TakeFound(const SurfacePieces& S);
  bool Divide(float longest_m, const DistanceField& field, const core::Pose& X_GS);
  void PlaceOnCandidates();
  bool SortCandidates(float longest_m, float voxel_m);
  void PlaceOnPieces();
  void FindDepthsOfPieces(const DistanceField& field, const core::Pose& X_GS, float exact_share);
  void AddPieces(float voxel_m, float weight);
  void FindDeepestPlace(const DistanceField& field, const core::Pose& X_GS, float exact_share);
  void OfferAsDeepest(std::uint32_t piece, std::uint32_t place, float voxel_m);
  void AddPiece(std::uint32_t i, float voxel_m, float weight, ContactPatch* patch);

  std::vector<std::uint32_t> queue_, next_queue_;
  std::uint32_t num_found_ = 0;  // pieces that may be inside, in queue_
  Triangles candidates_, halves_, pieces_;
  std::vector<float> sides_m2_;                                 // of candidates: the longest, squared
  std::vector<std::int32_t> longest_;                           // the corner at which it begins
  std::vector<std::pair<std::uint32_t, std::uint32_t>> order_;  // of pieces with exact places: on the curve, number
  std::vector<glm::vec3> inwards_;                              // of pieces: unit normal
  std::vector<PointBlock> points_;                              // normals are not used
  std::vector<SphereBlock> spheres_;
  std::vector<BlockDepths> depths_, exact_;
  ExactDepths exact_depths_;
  std::vector<ContactPatch> patches_;
  std::uint32_t num_patches_ = 0;
  float deepest_of_pieces_m_ = 0.0f;
  std::uint32_t deepest_piece_ = 0;
  Sums sums_;
};

}  // namespace vps
