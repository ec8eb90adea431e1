#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/MeshToVolume.h>

#include "tools/contact/contest.hpp"
#include "tools/contact_peers/peers.hpp"

namespace contact_peers {
namespace {

class OpenvdbMethod : public contact::Method {
 public:
  OpenvdbMethod(openvdb::FloatGrid::Ptr field, contact::Cooked B) : field_(std::move(field)), B_(std::move(B)) {}

  contact::Answer Query(const core::Pose& X_AB) override {
    auto accessor = field_->getConstAccessor();
    contact::Answer answer;
    answer.signed_distance_m = 1e9;
    for (const vps::PointBlock& block : B_->samples->points) {
      for (std::uint32_t k = 0; k < vps::kBlock; ++k) {
        if (block.area_m2[k] == 0.0f) continue;
        const glm::dvec3 p = X_AB * glm::dvec3(block.x[k], block.y[k], block.z[k]);
        const openvdb::Vec3d cell = field_->transform().worldToIndex({p.x, p.y, p.z});
        const double d = openvdb::tools::BoxSampler::sample(accessor, cell);
        answer.signed_distance_m = std::min(answer.signed_distance_m, d);
        if (d >= 0.0) continue;
        const glm::dvec3 f = -d * block.area_m2[k] * X_AB.rotate({block.nx[k], block.ny[k], block.nz[k]});
        answer.force_A += f;
        answer.moment_A += glm::cross(p - X_AB.translation, f);
        ++answer.contacts;
      }
    }
    answer.points_tested = B_->samples->num_points;
    return answer;
  }

 private:
  openvdb::FloatGrid::Ptr field_;
  contact::Cooked B_;
};

}  // namespace

core::Result<std::unique_ptr<contact::Method>> MakeOpenvdbMethod(const contact::Parts& parts, double voxel_size_m,
                                                                 contact::Structures* structures) {
  openvdb::initialize();
  std::vector<openvdb::Vec3s> points;
  for (const glm::dvec3& v : parts.A.vertices) points.emplace_back(v.x, v.y, v.z);
  std::vector<openvdb::Vec3I> triangles;
  for (const auto& t : parts.A.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  auto B = structures->Get({true, vps::Method::kFast, 0.0, contact::kMiddlePoints});
  if (!B) return tl::unexpected(B.error());
  auto field = openvdb::tools::meshToLevelSet<openvdb::FloatGrid>(
      *openvdb::math::Transform::createLinearTransform(voxel_size_m), points, triangles, 4.0f);
  return std::make_unique<OpenvdbMethod>(std::move(field), std::move(*B));
}

}  // namespace contact_peers
