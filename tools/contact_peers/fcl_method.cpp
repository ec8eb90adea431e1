#include <fcl/fcl.h>

#include <limits>

#include "tools/contact_peers/peers.hpp"

namespace contact_peers {
namespace {

using Model = fcl::BVHModel<fcl::OBBRSSd>;

std::shared_ptr<Model> MakeModel(const vps::TriangleMesh& mesh) {
  auto model = std::make_shared<Model>();
  std::vector<fcl::Vector3d> vertices;
  for (const glm::dvec3& v : mesh.vertices) vertices.emplace_back(v.x, v.y, v.z);
  std::vector<fcl::Triangle> triangles;
  for (const auto& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  model->beginModel(static_cast<int>(triangles.size()), static_cast<int>(vertices.size()));
  model->addSubModel(vertices, triangles);
  model->endModel();
  return model;
}

class FclMethod : public contact::Method {
 public:
  FclMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B) : A_(MakeModel(A)), B_(MakeModel(B)) {}

  contact::Answer Query(const core::Pose& X_AB) override {
    const glm::dquat& q = X_AB.rotation;
    fcl::Transform3d X = fcl::Transform3d::Identity();
    X.linear() = fcl::Quaterniond(q.w, q.x, q.y, q.z).toRotationMatrix();
    X.translation() = fcl::Vector3d(X_AB.translation.x, X_AB.translation.y, X_AB.translation.z);
    const fcl::Transform3d identity = fcl::Transform3d::Identity();
    fcl::CollisionObjectd a(A_, identity);
    fcl::CollisionObjectd b(B_, X);
    const fcl::CollisionRequestd request(std::numeric_limits<int>::max(), true);
    fcl::CollisionResultd result;
    fcl::collide(&a, &b, request, result);
    contact::Answer answer;
    answer.contacts = result.numContacts();
    for (std::size_t i = 0; i < result.numContacts(); ++i) {
      const fcl::Contactd& c = result.getContact(i);
      // The normal points from the first object to the second: the way B is pushed.
      const glm::dvec3 n(c.normal.x(), c.normal.y(), c.normal.z());
      const glm::dvec3 p(c.pos.x(), c.pos.y(), c.pos.z());
      const double depth = std::abs(c.penetration_depth);
      answer.force_A += depth * n;
      answer.moment_A += glm::cross(p - X_AB.translation, depth * n);
      answer.signed_distance_m = std::min(answer.signed_distance_m, -depth);
    }
    return answer;
  }

 private:
  std::shared_ptr<Model> A_;
  std::shared_ptr<Model> B_;
};

}  // namespace

core::Result<std::unique_ptr<contact::Method>> MakeFclMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B) {
  return std::make_unique<FclMethod>(A, B);
}

}  // namespace contact_peers
