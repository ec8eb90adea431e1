#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/MeshToVolume.h>

#include "tools/contact_peers/peers.hpp"
#include "vps/pointshell/pointshell.hpp"

namespace contact_peers {
namespace {

class OpenvdbMethod : public contact::Method {
 public:
  OpenvdbMethod(openvdb::FloatGrid::Ptr field, vps::Pointshell shell, double area_m2)
      : field_(std::move(field)), shell_(std::move(shell)), area_per_point_m2_(area_m2 / shell_.points_m.size()) {}

  contact::Answer Query(const core::Pose& X_AB) override {
    auto accessor = field_->getConstAccessor();
    contact::Answer answer;
    answer.signed_distance_m = 1e9;
    for (std::size_t i = 0; i < shell_.points_m.size(); ++i) {
      const glm::dvec3 p = X_AB * shell_.points_m[i];
      const openvdb::Vec3d cell = field_->transform().worldToIndex({p.x, p.y, p.z});
      const double d = openvdb::tools::BoxSampler::sample(accessor, cell);
      answer.signed_distance_m = std::min(answer.signed_distance_m, d);
      if (d >= 0.0) continue;
      const glm::dvec3 f = -d * area_per_point_m2_ * X_AB.rotate(shell_.inward_normals[i]);
      answer.force_A += f;
      answer.moment_A += glm::cross(p - X_AB.translation, f);
      ++answer.contacts;
    }
    answer.points_tested = shell_.points_m.size();
    return answer;
  }

 private:
  openvdb::FloatGrid::Ptr field_;
  vps::Pointshell shell_;
  double area_per_point_m2_;
};

}  // namespace

core::Result<std::unique_ptr<contact::Method>> MakeOpenvdbMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B,
                                                                 double voxel_size_m, std::uint32_t num_points) {
  openvdb::initialize();
  std::vector<openvdb::Vec3s> points;
  for (const glm::dvec3& v : A.vertices) points.emplace_back(v.x, v.y, v.z);
  std::vector<openvdb::Vec3I> triangles;
  for (const auto& t : A.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  auto shell = vps::BuildPointshell(B, num_points);
  if (!shell) return tl::unexpected(shell.error());
  auto field = openvdb::tools::meshToLevelSet<openvdb::FloatGrid>(
      *openvdb::math::Transform::createLinearTransform(voxel_size_m), points, triangles, 4.0f);
  return std::make_unique<OpenvdbMethod>(std::move(field), std::move(*shell), contact::SurfaceArea(B));
}

}  // namespace contact_peers
