#include "tools/dynamics/stack.hpp"

#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolver.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>

#include "physics/testing/trials/build.hpp"
#include "physics/testing/trials/heavy_on_light.hpp"

namespace dynamics {
namespace {

using physics::trials::HeavyOnLight;

class OurStack final : public Stack {
 public:
  OurStack(double ratio, physics::ContactKind kind) : trial_(ratio, kind) {}
  void Step() override { trial_.Step(); }
  [[nodiscard]] double deepest_m() const override { return trial_.deepest_m(); }

 private:
  HeavyOnLight trial_;
};

enum class Solver { kSequential, kDantzig };

class BulletStack final : public Stack {
 public:
  BulletStack(double ratio, Solver solver, int sweeps)
      : dispatcher_(&configuration_), shape_(btVector3(kHalf, kHalf, kHalf)), ground_shape_({5, 5, 5}) {
    if (solver == Solver::kSequential) solver_ = std::make_unique<btSequentialImpulseConstraintSolver>();
    if (solver == Solver::kDantzig) solver_ = std::make_unique<btMLCPSolver>(&dantzig_);
    world_ = std::make_unique<btDiscreteDynamicsWorld>(&dispatcher_, &broadphase_, solver_.get(), &configuration_);
    world_->setGravity({0, 0, -physics::trials::kGravity});
    world_->getSolverInfo().m_numIterations = sweeps;
    // Without it Dantzig's method fails on coplanar contacts and falls back to sequential impulses.
    if (solver == Solver::kDantzig) world_->getSolverInfo().m_globalCfm = 1e-6;
    Add(0.0, &ground_shape_, -5.0);
    Add(HeavyOnLight::kLight_kg, &shape_, kHalf);
    Add(HeavyOnLight::kLight_kg * ratio, &shape_, 3 * kHalf);
  }
  ~BulletStack() override {
    for (auto& body : bodies_) world_->removeRigidBody(body.get());
  }
  void Step() override {
    world_->stepSimulation(physics::trials::kDt, 0);
    deepest_m_ = std::max({deepest_m_, -Lowest_m(1), Top_m(1) - Lowest_m(2)});
  }
  [[nodiscard]] double deepest_m() const override { return deepest_m_; }

 private:
  static constexpr double kHalf = 0.5 * HeavyOnLight::kSide_m;

  void Add(double mass_kg, btBoxShape* shape, double z_m) {
    btVector3 inertia(0, 0, 0);
    if (mass_kg > 0.0) shape->calculateLocalInertia(mass_kg, inertia);
    btRigidBody::btRigidBodyConstructionInfo info(mass_kg, nullptr, shape, inertia);
    info.m_startWorldTransform.setIdentity();
    info.m_startWorldTransform.setOrigin({0, 0, z_m});
    info.m_friction = 0.55;  // Bullet multiplies the two: 0.3
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
    world_->addRigidBody(bodies_.back().get());
  }
  // The lowest corner of the lower face, and the middle of the upper face.
  [[nodiscard]] double Lowest_m(std::size_t body) const {
    double lowest = 1e9;
    for (const double x : {-kHalf, kHalf}) {
      for (const double y : {-kHalf, kHalf}) {
        lowest = std::min(lowest, bodies_[body]->getWorldTransform()(btVector3(x, y, -kHalf)).z());
      }
    }
    return lowest;
  }
  [[nodiscard]] double Top_m(std::size_t body) const {
    return bodies_[body]->getWorldTransform()(btVector3(0, 0, kHalf)).z();
  }

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btDantzigSolver dantzig_;
  std::unique_ptr<btConstraintSolver> solver_;
  std::unique_ptr<btDiscreteDynamicsWorld> world_;
  btBoxShape shape_;
  btBoxShape ground_shape_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  double deepest_m_ = 0.0;
};

}  // namespace

std::vector<StackMaker> OwnStacks() {
  const auto ours = [](physics::ContactKind kind) {
    return [kind](double ratio) { return std::make_unique<OurStack>(ratio, kind); };
  };
  const auto bullet = [](Solver solver, int sweeps) {
    return [solver, sweeps](double ratio) { return std::make_unique<BulletStack>(ratio, solver, sweeps); };
  };
  return {{"ours, hard", ours(physics::ContactKind::kHard)},
          {"ours, compliant", ours(physics::ContactKind::kCompliant)},
          {"Bullet, 10 sweeps", bullet(Solver::kSequential, 10)},
          {"Bullet, 100 sweeps", bullet(Solver::kSequential, 100)},
          {"Bullet, Dantzig", bullet(Solver::kDantzig, 10)}};
}

}  // namespace dynamics
