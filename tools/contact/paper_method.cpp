#include <algorithm>
#include <cmath>

#include "tools/contact/method.hpp"
#include "vps/force/force_scale.hpp"
#include "vps/force/penetration_sum.hpp"
#include "vps/query/tree_query.hpp"
#include "vps/tree/build_tree.hpp"
#include "vps/voxmap/build_voxmap.hpp"

namespace contact {
namespace {

class PaperMethod : public Method {
 public:
  PaperMethod(vps::Voxmap field, vps::PointTree points, double area_m2, bool as_integral)
      : field_(std::move(field)),
        points_(std::move(points)),
        scratch_(points_),
        area_per_point_m2_(area_m2 / points_.num_points),
        as_integral_(as_integral) {}

  Answer Query(const core::Pose& X_AB) override {
    const vps::QueryResult query = vps::QueryTree(points_, field_, X_AB, 0.0, &scratch_);
    Answer answer;
    answer.contacts = query.num_colliding;
    answer.points_tested = query.points_tested;
    if (query.num_hits == 0) {
      answer.signed_distance_m = std::max(query.free_distance_m, 0.0);
      return answer;
    }
    answer.signed_distance_m = -static_cast<double>(query.max_penetration_m);
    // f = sum V n, t = sum P x V n over the colliding points [VR-OOS, Eq. 1].
    vps::PenetrationSum sum_B;
    for (std::uint32_t i = 0; i < query.num_hits; ++i) {
      const std::uint32_t k = scratch_.hits[i].point;
      const glm::dvec3 f =
          static_cast<double>(scratch_.hits[i].penetration_m) * glm::dvec3(points_.nx[k], points_.ny[k], points_.nz[k]);
      sum_B.sum_m += f;
      sum_B.moment_m2 += glm::cross(glm::dvec3(points_.x[k], points_.y[k], points_.z[k]), f);
    }
    const double scale = as_integral_ ? area_per_point_m2_ : vps::ForceScale(query.num_colliding, points_.num_points);
    const vps::PenetrationSum sum_A = scale * vps::Rotate(X_AB, sum_B);
    answer.force_A = sum_A.sum_m;
    answer.moment_A = sum_A.moment_m2;
    return answer;
  }

 private:
  vps::Voxmap field_;
  vps::PointTree points_;
  vps::QueryScratch scratch_;
  double area_per_point_m2_;
  bool as_integral_;
};

}  // namespace

double SurfaceArea(const vps::TriangleMesh& mesh) {
  double area = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = mesh.corners(i);
    area += 0.5 * glm::length(glm::cross(b - a, c - a));
  }
  return area;
}

Resolution ResolveResolution(const vps::TriangleMesh& A, const vps::TriangleMesh& B, const Resolution& resolution) {
  Resolution resolved = resolution;
  const vps::Box box = vps::BoundingBox(A);
  const glm::dvec3 size = box.upper - box.lower;
  if (resolution.accuracy_m > 0.0) resolved.voxel_size_m = 3.0 * resolution.accuracy_m;
  if (resolved.voxel_size_m <= 0.0) resolved.voxel_size_m = std::max({size.x, size.y, size.z}) / 256.0;
  if (resolved.num_points == 0) {
    const double wanted = SurfaceArea(B) / (resolved.voxel_size_m * resolved.voxel_size_m);
    resolved.num_points = static_cast<std::uint32_t>(std::clamp(wanted, 1e3, resolution.accuracy_m > 0.0 ? 1e6 : 1e5));
  }
  return resolved;
}

core::Result<std::unique_ptr<Method>> MakePaperMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B,
                                                      const Resolution& resolution, bool as_integral) {
  const Resolution resolved = ResolveResolution(A, B, resolution);
  auto field = vps::BuildVoxmap(A, resolved.voxel_size_m);
  if (!field) return core::Fail(field.error().code, "A: " + field.error().detail);
  const auto shell = vps::BuildPointshell(B, resolved.num_points);
  if (!shell) return core::Fail(shell.error().code, "B: " + shell.error().detail);
  return std::make_unique<PaperMethod>(std::move(*field), vps::BuildTree(*shell), SurfaceArea(B), as_integral);
}

}  // namespace contact
