#pragma once

#include <optional>
#include <vector>

#include "core/pose.hpp"
#include "vps/surface/field_bends.hpp"
#include "vps/surface/node_integral.hpp"

namespace vps {

// The contact wrench of S's surface in the field of G to a wanted accuracy, with an estimate of its error.
//
//   force = integral over S of max(depth, 0) n dA,   moment = integral of x X max(depth, 0) n dA,
//
// n: inward normal. The front is a set of patches, nodes of S's tree or parts of its triangles, that together are S.
// Each has a depth and a slope, read at its centre, its integral in closed form (NodeIntegral), and an estimate of that
// integral's error. The patches with the largest errors are opened, or read exactly, until the sum is small enough.
// README.md derives the parts of the estimate.
class SurfaceIntegral {
 public:
  struct Result {
    glm::dvec3 force_m3{0.0};       // in S
    glm::dvec3 moment_m4{0.0};      // about S's mesh origin, in S
    double volume_m3 = 0.0;         // integral of depth
    double square_m4 = 0.0;         // integral of its square
    double deepest_m = 0.0;         // at the centre of a patch, greatest
    double error_m3 = 0.0;          // estimate of |force - the exact one|
    bool is_accurate = false;       // error_m3 is at most what was asked for; else patches or rounds ran out
    std::uint64_t places_read = 0;  // of the field
    std::uint64_t patches_inside = 0;
  };

  // Both must outlive it. `bends`: of the same field.
  SurfaceIntegral(const SurfaceTree& S, const DistanceField& G, const FieldBends& bends)
      : S_(S), G_(G), bends_(bends) {}

  // X_GS: pose of S in G. `accuracy`: wanted error over the greater of |force| and a hundredth of the integral of
  // depth, since opposite sides of a part in a hole cancel.
  Result Run(const core::Pose& X_GS, double accuracy);

 private:
  struct Patch {
    SurfaceNode node;
    std::optional<SurfacePiece> triangle;  // of a leaf or a part of one
    bool is_exact = false;                 // depth by G's triangles, and so for all its parts
    bool is_open = false;                  // its parts are in the front instead
    float depth_m = 0.0f;
    glm::vec3 slope{0.0f};
    float missed_mean_m = -1.0f;  // what its parent mispredicted, mean and r.m.s. over the siblings; -1: a root
    float missed_spread_m = 0.0f;
    const Bend* bend = nullptr;
    NodeIntegral integral;
    float bias_m3 = 0.0f;        // error of one sign
    float variance_m6 = 0.0f;    // of the rest
    float field_bias_m3 = 0.0f;  // the field's part of both
    float field_variance_m6 = 0.0f;
    bool is_straddling = false;
  };
  struct Estimate {
    double force_m3 = 0.0;  // what the error is compared with
    double bias_m3 = 0.0;
    double deviation_m3 = 0.0;
    [[nodiscard]] double error_m3() const { return bias_m3 + deviation_m3; }
  };

  [[nodiscard]] glm::vec3 InField(const glm::vec3& p_S) const { return R_GS_ * p_S * per_voxel_ + origin_; }
  void ReadField(Patch* patch);
  void ReadTriangles(Patch* patch);
  void Read(Patch* patch) { patch->is_exact ? ReadTriangles(patch) : ReadField(patch); }
  void Integrate(Patch* patch) const;
  void EstimateErrors(Patch* patch, float bend_m, float depth_m) const;
  void Offer(Patch patch);
  void Open(std::size_t i);
  void Divide(const Patch& patch, std::vector<Patch>* parts) const;
  [[nodiscard]] float WorthOfSide(const Patch& patch, const glm::vec3& side) const;
  [[nodiscard]] Estimate EstimateAll() const;
  [[nodiscard]] static double ShareOf(const Patch& patch, const Estimate& all);
  [[nodiscard]] double WantedOf(const Estimate& all, double accuracy) const;
  [[nodiscard]] double LeastShareToRefine(const Estimate& all, double wanted_m3) const;

  const SurfaceTree& S_;
  const DistanceField& G_;
  const FieldBends& bends_;
  glm::mat3 R_GS_{1.0f};
  glm::vec3 origin_{0.0f};
  float per_voxel_ = 1.0f;
  float voxel_m_ = 1.0f;
  std::vector<Patch> front_;
  std::vector<Patch> parts_;
  Result result_;
};

}  // namespace vps
