#include <algorithm>
#include <optional>

#include "tools/contact/methods/apart_bound.hpp"
#include "tools/contact/methods/method.hpp"
#include "vps/multibody/fast_pair_query.hpp"
#include "vps/walk/walk_memory.hpp"

namespace contact {
namespace {

class FastMethod : public Method {
 public:
  FastMethod(Cooked A, Cooked B, const FastGoal& goal, std::unique_ptr<ApartBound> apart)
      : A_(std::move(A)), B_(std::move(B)), apart_(std::move(apart)), scratch_(*B_->samples) {
    pair_.look_ahead_m = 0.0;
    pair_.accuracy = goal.accuracy;
    pair_.most_places = goal.most_places;
    pair_.negligible_N = goal.negligible_N;
    scratch_.walk.memory = &walk_memory_;
    scratch_.memory = &touch_memory_;
  }

  Answer Query(const core::Pose& X_AB) override {
    const vps::FastPair parts = vps::FastPairOf(*B_, *A_, touch_memory_);
    std::optional<double> apart_m;
    // The world frame is A's.
    if (apart_) {
      scratch_.found = vps::WalkField(parts.samples, parts.field, X_AB,
                                      vps::WalkMargin_m(parts.samples, pair_.look_ahead_m), &scratch_.walk);
      if (scratch_.found.num_colliding == 0) {
        apart_m = apart_->Query_m(X_AB);
        if (*apart_m > 0.0 && IsNoPartInside(X_AB)) {
          return {*apart_m, {}, {}, 0, scratch_.found.points_tested, 0.0, true};
        }
      }
      vps::FinishFastPair(parts, X_AB, X_AB, pair_, 0.01, &scratch_, &result_);
    } else {
      vps::QueryFastPair(parts, X_AB, X_AB, pair_, 0.01, &scratch_, &result_);
    }
    const vps::TouchIntegral& touch = scratch_.touch;
    const bool is_accurate = touch.error_m3 <= pair_.accuracy * touch.volume_m3;
    if (!result_.is_in_contact) {
      if (apart_ && !apart_m) apart_m = apart_->Query_m(X_AB);
      const double distance_m = apart_m.value_or(result_.signed_distance_m);
      return {distance_m, {}, {}, 0, result_.counters.points_tested, touch.error_m3, is_accurate};
    }
    return {result_.signed_distance_m,
            X_AB.rotate(touch.force_m3),
            X_AB.rotate(touch.moment_m4),
            result_.counters.points_colliding,
            result_.counters.points_tested,
            touch.error_m3,
            is_accurate};
  }

  void Forget() override {
    walk_memory_ = {};
    touch_memory_ = {};
  }

 private:
  // Where moreover the surfaces do not meet, there is no contact to integrate. Their triangles prove that in less time
  // than SurfaceWalk takes to read A's field closely wherever B is near.
  [[nodiscard]] bool IsNoPartInside(const core::Pose& X_AB) const {
    const vps::FieldTransform T(X_AB, *A_->field);
    const auto& corners_m = apart_->corners_of_S_m();
    return std::all_of(corners_m.begin(), corners_m.end(), [&](const glm::dvec3& p_B) {
      return vps::SampleField(*A_->field, T.ToVoxels(glm::vec3(p_B))).distance > 0.0f;
    });
  }

  Cooked A_;
  Cooked B_;
  std::unique_ptr<ApartBound> apart_;  // none: the distance is the query's own
  vps::PairDescription pair_;
  vps::PairResult result_;
  vps::FastPairScratch scratch_;
  // Save work when consecutive poses are near each other.
  vps::FieldWalkMemory walk_memory_;
  vps::TouchMemory touch_memory_;
};

}  // namespace

std::unique_ptr<Method> MakeFastMethod(Cooked A, Cooked B, const FastGoal& goal) {
  return std::make_unique<FastMethod>(std::move(A), std::move(B), goal, nullptr);
}

core::Result<std::unique_ptr<Method>> MakeFastMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B,
                                                     const Resolution& resolution, const FastGoal& goal,
                                                     const Cooking& cooking) {
  auto cooked_A = vps::Cook(A, {resolution.voxel_size_m, 0, vps::Method::kFast}, cooking.progress_A, cooking.workers);
  if (!cooked_A) return core::Fail(cooked_A.error().code, "the field's body: " + cooked_A.error().detail);
  auto cooked_B = vps::Cook(B, {0.0, resolution.num_points, vps::Method::kFast}, cooking.progress_B, cooking.workers);
  if (!cooked_B) return core::Fail(cooked_B.error().code, "the sampled body: " + cooked_B.error().detail);
  return std::make_unique<FastMethod>(std::make_shared<const vps::CookedObject>(std::move(*cooked_A)),
                                      std::make_shared<const vps::CookedObject>(std::move(*cooked_B)), goal,
                                      std::make_unique<ApartBound>(A, B));
}

}  // namespace contact
