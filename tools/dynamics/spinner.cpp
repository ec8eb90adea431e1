#include "tools/dynamics/spinner.hpp"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <btBulletDynamicsCommon.h>

#include "physics/world.hpp"

namespace dynamics {
namespace {

class OurSpinner final : public Spinner {
 public:
  explicit OurSpinner(const SpinnerParams& params) : dt_s_(params.dt_s) {
    physics::MassProperties mass;
    mass.I_Cm_O_kg_m2 = glm::dmat3(0.0);
    for (int i = 0; i < 3; ++i) mass.I_Cm_O_kg_m2[i][i] = params.moments_kg_m2[i];
    for (int i = 0; i < params.num_bodies; ++i) {
      const core::Pose X_WO{{1, 0, 0, 0}, {100.0 * i, 0, 0}};
      world_.AddBody({physics::BodyKind::kDynamic, X_WO, {params.w_B_rad_per_s, {}}, mass}).value();
    }
    first_ = world_.world_body() == 0 ? 1 : 0;
  }
  void Step() override { world_.Step(dt_s_); }
  [[nodiscard]] glm::dquat R_WB() const override { return world_.X_WO(first_).rotation; }
  [[nodiscard]] glm::dvec3 w_B_rad_per_s() const override {
    return glm::conjugate(R_WB()) * world_.V_WO(first_).angular_rad_per_s;
  }

 private:
  physics::World world_;
  double dt_s_;
  int first_;
};

// Bullet's world with its default settings, but without gravity and sleeping.
class BulletSpinner final : public Spinner {
 public:
  BulletSpinner(const SpinnerParams& params, int flags)
      : dt_s_(params.dt_s),
        dispatcher_(&configuration_),
        world_(&dispatcher_, &broadphase_, &solver_, &configuration_),
        shape_({0.1, 0.1, 0.1}) {
    world_.setGravity({0, 0, 0});
    for (int i = 0; i < params.num_bodies; ++i) {
      const glm::dvec3& I = params.moments_kg_m2;
      btRigidBody::btRigidBodyConstructionInfo info(1.0, nullptr, &shape_, {I.x, I.y, I.z});
      info.m_startWorldTransform.setIdentity();
      info.m_startWorldTransform.setOrigin({100.0 * i, 0, 0});
      bodies_.push_back(std::make_unique<btRigidBody>(info));
      const glm::dvec3& w = params.w_B_rad_per_s;
      bodies_.back()->setAngularVelocity({w.x, w.y, w.z});
      bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
      bodies_.back()->setFlags(flags);
      world_.addRigidBody(bodies_.back().get());
    }
  }
  ~BulletSpinner() override {
    for (auto& body : bodies_) world_.removeRigidBody(body.get());
  }
  void Step() override { world_.stepSimulation(dt_s_, 0); }
  [[nodiscard]] glm::dquat R_WB() const override {
    const btQuaternion q = bodies_[0]->getWorldTransform().getRotation();
    return {q.w(), q.x(), q.y(), q.z()};
  }
  [[nodiscard]] glm::dvec3 w_B_rad_per_s() const override {
    const btVector3 w = bodies_[0]->getAngularVelocity();
    return glm::conjugate(R_WB()) * glm::dvec3(w.x(), w.y(), w.z());
  }

 private:
  double dt_s_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_;
  btBoxShape shape_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
};

SpinnerMaker Bullet(const char* name, int flags) {
  return {name, [flags](const SpinnerParams& params) { return std::make_unique<BulletSpinner>(params, flags); }};
}

}  // namespace

std::vector<SpinnerMaker> OwnSpinners() {
  return {{"ours", [](const SpinnerParams& params) { return std::make_unique<OurSpinner>(params); }},
          Bullet("Bullet, default", BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY),
          Bullet("Bullet, implicit world", BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_WORLD),
          Bullet("Bullet, explicit", BT_ENABLE_GYROSCOPIC_FORCE_EXPLICIT),
          Bullet("Bullet, none", 0)};
}

}  // namespace dynamics
