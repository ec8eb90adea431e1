#include "tools/contact/methods/setup.hpp"

#include "scene/load_scenario.hpp"
#include "vps/asset/choose_resolution.hpp"
#include "vps/mesh/part_size.hpp"

namespace contact {
namespace {

std::string Feature(const vps::PartSize& part) {
  return vps::Millimetres(vps::SmallestFeature_m(part));
}

class TurnedMethod : public Method {
 public:
  explicit TurnedMethod(std::unique_ptr<Method> of_B_and_A) : of_B_and_A_(std::move(of_B_and_A)) {}

  Answer Query(const core::Pose& X_AB) override {
    Answer answer = of_B_and_A_->Query(X_AB.inverse());
    // On A, about A's origin; its opposite is on B, and B's origin is X_AB.translation away.
    const glm::dvec3 on_A_A = X_AB.rotate(answer.force_A);
    const glm::dvec3 moment_on_A_A = X_AB.rotate(answer.moment_A);
    answer.force_A = glm::dvec3(0.0) - on_A_A;  // no negative zeros
    answer.moment_A = glm::cross(X_AB.translation, on_A_A) - moment_on_A_A;
    return answer;
  }
  void Forget() override { of_B_and_A_->Forget(); }

 private:
  std::unique_ptr<Method> of_B_and_A_;
};

}  // namespace

Setup ChooseSetup(const vps::TriangleMesh& A, const vps::TriangleMesh& B, const SetupWish& wish) {
  const vps::PartSize size_A = vps::MeasurePart(A);
  const vps::PartSize size_B = vps::MeasurePart(B);
  Setup setup;
  setup.is_A_sampled = wish.is_A_sampled.value_or(vps::IsFirstSampled(size_A, size_B));
  const vps::PartSize& S = setup.is_A_sampled ? size_A : size_B;
  const vps::PartSize& G = setup.is_A_sampled ? size_B : size_A;
  const std::string name_S = setup.is_A_sampled ? "A" : "B";
  const std::string name_G = setup.is_A_sampled ? "B" : "A";
  setup.text =
      name_S + " is sampled (" +
      (wish.is_A_sampled ? "as asked for" : "smallest feature " + Feature(S) + ", of " + name_G + " " + Feature(G)) +
      ")";
  if (!wish.method) return setup;

  setup.resolution = wish.given;
  std::string voxel_reason = "as asked for";
  if (setup.resolution.voxel_size_m <= 0.0) {
    const vps::ChosenVoxel voxel =
        vps::ChooseVoxel(G, S, {*wish.method, wish.accuracy, scene::kMinVoxelSize_m, scene::kMaxVoxelSize_m});
    setup.resolution.voxel_size_m = voxel.size_m;
    voxel_reason = voxel.reason;
  }
  if (setup.resolution.num_points == 0) {
    setup.resolution.num_points = vps::ChoosePoints(S.area_m2, setup.resolution.voxel_size_m);
  }
  setup.text += "; voxels of " + name_G + " " + vps::Millimetres(setup.resolution.voxel_size_m) + " (" + voxel_reason +
                "); points on " + name_S + " " + std::to_string(setup.resolution.num_points) + " (" +
                (wish.given.num_points > 0 ? "as asked for" : "one voxel apart, 1,000 to 100,000") + ")";
  return setup;
}

std::unique_ptr<Method> Turned(std::unique_ptr<Method> of_B_and_A) {
  return std::make_unique<TurnedMethod>(std::move(of_B_and_A));
}

}  // namespace contact
