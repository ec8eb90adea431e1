#include "tools/failures/bullet_loop.hpp"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <memory>
#include <vector>

namespace failures {
namespace {

constexpr double kTick_s = 1e-3;
constexpr double kMargin_m = 1e-4;

btVector3 ToBullet(const glm::dvec3& v) {
  return {v.x, v.y, v.z};
}
glm::dvec3 FromBullet(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}
btTransform ToBullet(const core::Pose& X) {
  const glm::dquat& q = X.rotation;
  return btTransform(btQuaternion(q.x, q.y, q.z, q.w), ToBullet(X.translation));
}

struct MeshBody {
  // `inertia_kg_m2`: about every axis; 0: of the mesh.
  MeshBody(const vps::TriangleMesh& mesh, const core::Pose& X_WO, double mass_kg, double inertia_kg_m2,
           double friction) {
    for (const glm::dvec3& v : mesh.vertices) vertices.push_back(ToBullet(v));
    for (const auto& t : mesh.triangles)
      for (const std::uint32_t corner : t) corners.push_back(static_cast<int>(corner));
    array = std::make_unique<btTriangleIndexVertexArray>(
        static_cast<int>(mesh.triangles.size()), corners.data(), static_cast<int>(3 * sizeof(int)),
        static_cast<int>(vertices.size()), vertices.data()->m_floats, static_cast<int>(sizeof(btVector3)));
    shape = std::make_unique<btGImpactMeshShape>(array.get());
    shape->setMargin(kMargin_m);
    shape->updateBound();
    btVector3 inertia(inertia_kg_m2, inertia_kg_m2, inertia_kg_m2);
    if (mass_kg > 0.0 && inertia_kg_m2 == 0.0) shape->calculateLocalInertia(mass_kg, inertia);
    btRigidBody::btRigidBodyConstructionInfo info(mass_kg, nullptr, shape.get(), inertia);
    info.m_friction = std::sqrt(friction);  // Bullet multiplies those of the two bodies
    info.m_startWorldTransform = ToBullet(X_WO);
    body = std::make_unique<btRigidBody>(info);
    body->setActivationState(DISABLE_DEACTIVATION);
  }

  std::vector<btVector3> vertices;
  std::vector<int> corners;
  std::unique_ptr<btTriangleIndexVertexArray> array;
  std::unique_ptr<btGImpactMeshShape> shape;
  std::unique_ptr<btRigidBody> body;
};

class BulletLoop final : public PeerLoop {
 public:
  explicit BulletLoop(double friction) : friction_(friction) {
    btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher_);
    world_.setGravity({0, 0, 0});
  }
  ~BulletLoop() override {
    for (const auto& one : bodies_) world_.removeRigidBody(one->body.get());
  }
  BulletLoop(const BulletLoop&) = delete;
  BulletLoop& operator=(const BulletLoop&) = delete;

  void AddFixed(const vps::TriangleMesh& mesh, const core::Pose& X_WO) override { AddBall(mesh, X_WO, 0.0, 0.0); }
  void AddBody(const vps::TriangleMesh& mesh, const core::Pose& X_WO, double mass_kg) override {
    AddBall(mesh, X_WO, mass_kg, 0.0);
  }
  using PeerLoop::Tick;
  void Tick() override { world_.stepSimulation(kTick_s, 0); }

  [[nodiscard]] core::Pose X_WC() const override {
    const btTransform& X = last().getWorldTransform();
    const btQuaternion q = X.getRotation();
    return {glm::dquat(q.w(), q.x(), q.y(), q.z()), FromBullet(X.getOrigin())};
  }
  [[nodiscard]] core::Twist V_WC() const override {
    return {FromBullet(last().getAngularVelocity()), FromBullet(last().getLinearVelocity())};
  }
  [[nodiscard]] bool is_in_contact() const override {
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i) {
      if (dispatcher_.getManifoldByIndexInternal(i)->getNumContacts() > 0) return true;
    }
    return false;
  }

 protected:
  void AddBall(const vps::TriangleMesh& mesh, const core::Pose& X_WO, double mass_kg, double inertia_kg_m2) override {
    bodies_.push_back(std::make_unique<MeshBody>(mesh, X_WO, mass_kg, inertia_kg_m2, friction_));
    world_.addRigidBody(bodies_.back()->body.get());
  }
  void Push(const core::Wrench& F_W) override {
    last().applyCentralForce(ToBullet(F_W.force_N));
    last().applyTorque(ToBullet(F_W.torque_Nm));
  }
  void PutAtRest(const core::Pose& X_WO) override {
    last().setWorldTransform(ToBullet(X_WO));
    last().setInterpolationWorldTransform(ToBullet(X_WO));
    last().setLinearVelocity({0, 0, 0});
    last().setAngularVelocity({0, 0, 0});
    last().clearForces();
  }

 private:
  [[nodiscard]] btRigidBody& last() const { return *bodies_.back()->body; }

  double friction_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::vector<std::unique_ptr<MeshBody>> bodies_;
};

}  // namespace

Peer BulletPeer() {
  Peer peer;
  peer.name = "Bullet";
  peer.takes_concave = true;
  peer.make_loop = [](double friction) { return std::make_unique<BulletLoop>(friction); };
  for (const dynamics::StackMaker& maker : dynamics::OwnStacks()) {
    if (maker.name == "Bullet, 10 sweeps") peer.stack = maker;
  }
  return peer;
}

}  // namespace failures
