#include "tools/failures/bullet_loop.hpp"

#include <BulletCollision/Gimpact/btGImpactCollisionAlgorithm.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <vector>

namespace failures {
namespace {

constexpr double kTick_s = 1e-3;
constexpr double kMargin_m = 1e-4;
// K T^2 / m of the explicit spring with critical damping, B T / m = 2 sqrt(0.1): a fifth of what is stable.
constexpr double kExplicit = 0.1;
constexpr double kLeast = kTick_s * kTick_s / kExplicit;  // mass over stiffness

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

}  // namespace

struct BulletLoop::World {
  explicit World(double mu) : friction(mu) {
    btGImpactCollisionAlgorithm::registerAlgorithm(&dispatcher);
    world.setGravity({0, 0, 0});
  }
  ~World() {
    for (const auto& one : bodies) world.removeRigidBody(one->body.get());
  }
  void Add(const vps::TriangleMesh& mesh, const core::Pose& X_WO, double mass_kg, double inertia_kg_m2) {
    bodies.push_back(std::make_unique<MeshBody>(mesh, X_WO, mass_kg, inertia_kg_m2, friction));
    world.addRigidBody(bodies.back()->body.get());
  }
  [[nodiscard]] btRigidBody& tool() const { return *bodies.back()->body; }

  double friction;
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
  std::vector<std::unique_ptr<MeshBody>> bodies;
};

BulletLoop::BulletLoop(double friction) : world_(std::make_unique<World>(friction)) {}
BulletLoop::~BulletLoop() = default;

void BulletLoop::AddFixed(const vps::TriangleMesh& mesh, const core::Pose& X_WO) {
  world_->Add(mesh, X_WO, 0.0, 0.0);
}
void BulletLoop::AddBody(const vps::TriangleMesh& mesh, const core::Pose& X_WO, double mass_kg) {
  world_->Add(mesh, X_WO, mass_kg, 0.0);
}
void BulletLoop::AddTool(const vps::TriangleMesh& mesh, const core::Pose& X_WD) {
  world_->Add(mesh, X_WD, coupling_.stiffness_N_per_m * kLeast, coupling_.stiffness_Nm_per_rad * kLeast);
  X_WD_before_ = X_WD;
}

void BulletLoop::Tick(const core::Pose& X_WD) {
  btRigidBody& tool = world_->tool();
  const core::Pose X_WT = X_WC();
  const glm::dvec3 v_D = (X_WD.translation - X_WD_before_.translation) / kTick_s;
  const glm::dvec3 w_D = core::RotationVector(X_WD.rotation * glm::conjugate(X_WD_before_.rotation)) / kTick_s;
  const glm::dvec3 turn = core::RotationVector(X_WD.rotation * glm::conjugate(X_WT.rotation));
  const double T_critical_s = 2.0 * std::sqrt(kLeast);  // damping over stiffness
  const glm::dvec3 F = coupling_.stiffness_N_per_m * (X_WD.translation - X_WT.translation +
                                                      T_critical_s * (v_D - FromBullet(tool.getLinearVelocity())));
  const glm::dvec3 M =
      coupling_.stiffness_Nm_per_rad * (turn + T_critical_s * (w_D - FromBullet(tool.getAngularVelocity())));
  tool.applyCentralForce(ToBullet(F));
  tool.applyTorque(ToBullet(M));
  command_ = {-F, -M};
  X_WD_before_ = X_WD;
  Tick();
}

void BulletLoop::LetGo(const core::Pose& X_WD) {
  btRigidBody& tool = world_->tool();
  tool.setWorldTransform(ToBullet(X_WD));
  tool.setInterpolationWorldTransform(ToBullet(X_WD));
  tool.setLinearVelocity({0, 0, 0});
  tool.setAngularVelocity({0, 0, 0});
  tool.clearForces();
  X_WD_before_ = X_WD;
}

void BulletLoop::Tick() {
  world_->world.stepSimulation(kTick_s, 0);
}

core::Pose BulletLoop::X_WC() const {
  const btTransform& X = world_->tool().getWorldTransform();
  const btQuaternion q = X.getRotation();
  return {glm::dquat(q.w(), q.x(), q.y(), q.z()), FromBullet(X.getOrigin())};
}

double BulletLoop::speed_m_per_s() const {
  return world_->tool().getLinearVelocity().length();
}

bool BulletLoop::is_in_contact() const {
  for (int i = 0; i < world_->dispatcher.getNumManifolds(); ++i) {
    if (world_->dispatcher.getManifoldByIndexInternal(i)->getNumContacts() > 0) return true;
  }
  return false;
}

}  // namespace failures
