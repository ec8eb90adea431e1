#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/pose.hpp"
#include "core/result.hpp"
#include "vps/asset/cooked_object.hpp"
#include "vps/mesh/triangle_mesh.hpp"

namespace contact {

// What a method says of one pose. Frames: A's mesh frame; moments about B's mesh origin.
struct Answer {
  double signed_distance_m = 0.0;  // negative: deepest penetration
  glm::dvec3 force_A{0.0};         // on B. m^3 (depth integral) or, for Eq. 1-2 sums, m
  glm::dvec3 moment_A{0.0};        // m^4 or m^2
  std::uint64_t contacts = 0;
  std::uint64_t points_tested = 0;
};

// One way of answering for one pair of meshes, built once.
class Method {
 public:
  virtual ~Method() = default;
  virtual Answer Query(const core::Pose& X_AB) = 0;
};

// A method's resolution. Zero: chosen from the meshes.
struct Resolution {
  double accuracy_m = 0.0;       // wanted error of a depth; excludes the two others
  double voxel_size_m = 0.0;     // of A's field
  std::uint32_t num_points = 0;  // on B's surface
};

// What `paper` and `fast` would use for these meshes: no zeros left. An accuracy of x takes voxels of 3 x and points
// one voxel apart. By default the voxel is 1/256 of the longest side of A, and points are one voxel apart, 1,000 to
// 100,000 (1,000,000 with accuracy).
Resolution ResolveResolution(const vps::TriangleMesh& A, const vps::TriangleMesh& B, const Resolution& resolution);

using Cooked = std::shared_ptr<const vps::CookedObject>;

// Method `paper`: points of B against the voxelmap of A, Eq. 1-2 [VR-OOS]: force = lambda sum V n in m, moment in m^2.
// With `as_integral`, each point's V n counts with its share of B's area instead of lambda, which gives m^3 and m^4.
std::unique_ptr<Method> MakePaperMethod(Cooked A, Cooked B, double area_B_m2, bool as_integral);
core::Result<std::unique_ptr<Method>> MakePaperMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B,
                                                      const Resolution& resolution);

// Method `fast`: the product's pair query; the depth integral and its moment. From cooked objects its distance when
// apart is the query's own, that of the nearest sample; from meshes a lower bound of the surfaces' (ApartBound_m),
// looked for besides.
std::unique_ptr<Method> MakeFastMethod(Cooked A, Cooked B);
core::Result<std::unique_ptr<Method>> MakeFastMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B,
                                                     const Resolution& resolution);

// The exact answers of vps/oracle. Needs no resolution.
core::Result<std::unique_ptr<Method>> MakeOracleMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B,
                                                       double relative_accuracy = 1e-4);

double SurfaceArea(const vps::TriangleMesh& mesh);

}  // namespace contact
