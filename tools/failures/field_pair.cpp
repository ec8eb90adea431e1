#include "tools/failures/field_pair.hpp"

namespace failures {

FieldPair::FieldPair(const Variant& variant, const vps::TriangleMesh& field, double voxel_m,
                     const vps::TriangleMesh& sampled, std::uint32_t num_points, Palm palm) {
  const SetUpLock lock;
  SceneKit kit(variant);
  const auto G = palm == Palm::kField ? kit.AddHand(field, {}, 0) : kit.AddFixed(field, {}, voxel_m);
  const auto S =
      palm == Palm::kSampled ? kit.AddHand(sampled, {}, num_points) : kit.AddFixed(sampled, {}, 0.0, num_points);
  kit.scenario.objects[G].voxel_size_m = voxel_m;
  kit.AddPair(S, G);
  collision::Options options;
  options.cache = WorkFolder() / "cache";
  owned_ = Must(collision::BuildOwnedWorld(kit.scenario, scene::PairOwner::kHaptic, serial_, options));
}

const vps::PairResult& FieldPair::Query(const core::Pose& X_GS, std::uint64_t budget_points) {
  constexpr std::int64_t kUnlimited_ns = 3600'000'000'000;
  owned_.world->SetPose(1, X_GS);
  report_ =
      budget_points == 0 ? &owned_.world->Step(&serial_) : &owned_.world->Step(&serial_, kUnlimited_ns, budget_points);
  return owned_.world->result(0);
}

}  // namespace failures
