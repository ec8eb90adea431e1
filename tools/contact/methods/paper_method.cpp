#include <algorithm>
#include <cmath>

#include "tools/contact/methods/method.hpp"
#include "vps/force/force_scale.hpp"
#include "vps/force/penetration_sum.hpp"
#include "vps/query/tree_query.hpp"

namespace contact {
namespace {

class PaperMethod : public Method {
 public:
  PaperMethod(Cooked A, Cooked B, double area_B_m2, bool as_integral)
      : A_(std::move(A)),
        B_(std::move(B)),
        field_(*A_->voxmap),
        points_(*B_->points),
        scratch_(points_),
        area_per_point_m2_(area_B_m2 / points_.num_points),
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
  Cooked A_;
  Cooked B_;
  const vps::Voxmap& field_;
  const vps::PointTree& points_;
  vps::QueryScratch scratch_;
  double area_per_point_m2_;
  bool as_integral_;
};

}  // namespace

std::unique_ptr<Method> MakePaperMethod(Cooked A, Cooked B, double area_B_m2, bool as_integral) {
  return std::make_unique<PaperMethod>(std::move(A), std::move(B), area_B_m2, as_integral);
}

core::Result<std::unique_ptr<Method>> MakePaperMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B,
                                                      const Resolution& resolution, const Cooking& cooking) {
  auto cooked_A = vps::Cook(A, {resolution.voxel_size_m, 0, vps::Method::kPaper}, cooking.progress_A, cooking.workers);
  if (!cooked_A) return core::Fail(cooked_A.error().code, "the field's body: " + cooked_A.error().detail);
  auto cooked_B = vps::Cook(B, {0.0, resolution.num_points, vps::Method::kPaper}, cooking.progress_B, cooking.workers);
  if (!cooked_B) return core::Fail(cooked_B.error().code, "the sampled body: " + cooked_B.error().detail);
  return MakePaperMethod(std::make_shared<const vps::CookedObject>(std::move(*cooked_A)),
                         std::make_shared<const vps::CookedObject>(std::move(*cooked_B)), vps::SurfaceArea_m2(B),
                         false);
}

}  // namespace contact
