#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletCollisionCommon.h>

#include "tools/contact_peers/peers.hpp"

namespace contact_peers {
namespace {

struct Body {
  explicit Body(const vps::TriangleMesh& mesh) {
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      const auto [a, b, c] = mesh.corners(i);
      triangles.addTriangle({a.x, a.y, a.z}, {b.x, b.y, b.z}, {c.x, c.y, c.z});
    }
    shape = std::make_unique<btGImpactMeshShape>(&triangles);
    shape->setMargin(0.0);
    shape->updateBound();
    object.setCollisionShape(shape.get());
  }
  btTriangleMesh triangles;
  std::unique_ptr<btGImpactMeshShape> shape;
  btCollisionObject object;
};

class GimpactMethod : public contact::Method {
 public:
  GimpactMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B)
      : a_(A), b_(B), dispatcher_(&configuration_), world_(&dispatcher_, &broadphase_, &configuration_) {
    btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher_);
    world_.addCollisionObject(&a_.object);
    world_.addCollisionObject(&b_.object);
  }
  ~GimpactMethod() override {
    world_.removeCollisionObject(&a_.object);
    world_.removeCollisionObject(&b_.object);
  }

  contact::Answer Query(const core::Pose& X_AB) override {
    const glm::dquat& q = X_AB.rotation;
    const glm::dvec3& p = X_AB.translation;
    b_.object.setWorldTransform(btTransform(btQuaternion(q.x, q.y, q.z, q.w), btVector3(p.x, p.y, p.z)));
    world_.performDiscreteCollisionDetection();
    contact::Answer answer;
    for (int m = 0; m < dispatcher_.getNumManifolds(); ++m) {
      const btPersistentManifold* manifold = dispatcher_.getManifoldByIndexInternal(m);
      const bool is_a_first = manifold->getBody0() == &a_.object;
      for (int i = 0; i < manifold->getNumContacts(); ++i) {
        const btManifoldPoint& c = manifold->getContactPoint(i);
        if (c.getDistance() > 0.0) continue;
        // m_normalWorldOnB points towards the manifold's first body.
        const btVector3 normal = is_a_first ? btVector3(-c.m_normalWorldOnB) : c.m_normalWorldOnB;
        const btVector3& at = is_a_first ? c.getPositionWorldOnB() : c.getPositionWorldOnA();
        const glm::dvec3 f = -c.getDistance() * glm::dvec3(normal.x(), normal.y(), normal.z());
        answer.force_A += f;
        answer.moment_A += glm::cross(glm::dvec3(at.x(), at.y(), at.z()) - p, f);
        answer.signed_distance_m = std::min(answer.signed_distance_m, static_cast<double>(c.getDistance()));
        ++answer.contacts;
      }
    }
    return answer;
  }

 private:
  Body a_;
  Body b_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btCollisionWorld world_;
};

}  // namespace

core::Result<std::unique_ptr<contact::Method>> MakeGimpactMethod(const vps::TriangleMesh& A,
                                                                 const vps::TriangleMesh& B) {
  return std::make_unique<GimpactMethod>(A, B);
}

}  // namespace contact_peers
