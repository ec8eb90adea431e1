#include <algorithm>

#include "tools/contact/method.hpp"
#include "vps/field/build_field.hpp"
#include "vps/sampling/sample_tree.hpp"
#include "vps/walk/field_walk.hpp"

namespace contact {
namespace {

class FastMethod : public Method {
 public:
  FastMethod(vps::DistanceField field, vps::SampleTree samples)
      : field_(std::move(field)), samples_(std::move(samples)), scratch_(samples_) {}

  Answer Query(const core::Pose& X_AB) override {
    const vps::FieldWalkResult walk = vps::WalkField(samples_, field_, X_AB, 0.0, &scratch_);
    Answer answer;
    answer.contacts = walk.num_colliding;
    answer.points_tested = walk.points_tested;
    if (walk.num_near == 0) {
      answer.signed_distance_m = std::max(walk.free_distance_m, 0.0);
      return answer;
    }
    answer.signed_distance_m = -walk.deepest_m;
    answer.force_A = X_AB.rotate(walk.force_m3);
    answer.moment_A = X_AB.rotate(walk.moment_m4);
    return answer;
  }

 private:
  vps::DistanceField field_;
  vps::SampleTree samples_;
  vps::FieldWalkScratch scratch_;
};

}  // namespace

core::Result<std::unique_ptr<Method>> MakeFastMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B,
                                                     const Resolution& resolution) {
  const Resolution resolved = ResolveResolution(A, B, resolution);
  auto field = vps::BuildField(A, resolved.voxel_size_m);
  if (!field) return core::Fail(field.error().code, "A: " + field.error().detail);
  const auto samples = vps::SampleSurface(B, resolved.num_points);
  if (!samples) return core::Fail(samples.error().code, "B: " + samples.error().detail);
  return std::make_unique<FastMethod>(std::move(*field), vps::BuildSampleTree(*samples));
}

}  // namespace contact
