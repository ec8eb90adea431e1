#pragma once

#include <BulletCollision/BroadphaseCollision/btSimpleBroadphase.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>

#include <array>
#include <memory>
#include <vector>

#include "physics/engine/bullet_conversions.hpp"
#include "physics/engine/bullet_world.hpp"
#include "physics/engine/contact_feed.hpp"
#include "physics/engine/rigid_body.hpp"
#include "physics/engine/row_solver.hpp"
#include "physics/world.hpp"

namespace physics {

constexpr int kMaxBodies = 512;  // capacity of a world

struct PairSlot {
  int sampled = 0;
  int field = 0;
  ContactFeed feed;
  bool has_wrench = false;
  bool is_muted = false;
  core::Wrench F_So_W;
  ContactReport report;
};

struct MechanismSlot {
  int parent = 0;
  int child = 0;
  std::unique_ptr<Mechanism> mechanism;
  std::unique_ptr<RowConstraint> constraint;
};

struct World::Impl {
  explicit Impl(const Options& options)
      : dispatcher(&configuration),
        broadphase(kMaxBodies),
        world(&dispatcher, &broadphase, &solver, &configuration),
        gravity_W_m_per_s2(options.gravity_W_m_per_s2) {
    world.setGravity(btVector3(0, 0, 0));  // ApplyWeights books it
    world.set_bodies(&collision_objects);
    btContactSolverInfo& info = world.getSolverInfo();
    info.m_numIterations = options.max_iterations;
    info.m_leastSquaresResidualThreshold = options.tolerance_m_per_s * options.tolerance_m_per_s;
    info.m_splitImpulse = 0;
    info.m_solverMode = SOLVER_USE_WARMSTARTING | SOLVER_USE_2_FRICTION_DIRECTIONS;
    info.m_warmstartingFactor = 1.0;
    info.m_damping = 1.0;
  }
  ~Impl() {
    for (MechanismSlot& slot : mechanisms) world.removeConstraint(slot.constraint.get());
    for (RigidBody& body : bodies) world.removeRigidBody(body.engine.get());
    // Bullet frees only manifolds of its own pool.
    while (dispatcher.getNumManifolds() > 0) dispatcher.releaseManifold(dispatcher.getManifoldByIndexInternal(0));
  }

  void Apply(ImpulseSource source, RigidBody* body, const glm::dvec3& p_W, const glm::dvec3& impulse_W,
             const glm::dvec3& couple_W) {
    if (body->kind != BodyKind::kDynamic) return;
    body->impulses_Ns += impulse_W;
    const glm::dvec3 angular = glm::cross(p_W, impulse_W) + couple_W;
    body->angular_impulses_Nms += angular;
    body->account.Add(source, impulse_W, angular);
    magnitudes[static_cast<std::size_t>(source)].Ns += glm::length(impulse_W);
    magnitudes[static_cast<std::size_t>(source)].Nms += glm::length(angular);
  }

  void ApplyWrenches(double dt_s) {
    for (PairSlot& pair : pairs) {
      if (!pair.has_wrench || pair.is_muted) continue;
      RigidBody& s = bodies[static_cast<std::size_t>(pair.sampled)];
      RigidBody& g = bodies[static_cast<std::size_t>(pair.field)];
      const glm::dvec3 p_WSo = s.X_WO().translation;
      for (const auto& [body, sign] : {std::pair{&s, 1.0}, std::pair{&g, -1.0}}) {
        if (body->kind != BodyKind::kDynamic) continue;
        const core::Wrench F_Cm =
            core::ShiftWrench(sign * pair.F_So_W, p_WSo - body->p_WCm);  // same point, about this body's Cm
        body->engine->applyCentralForce(ToBullet(F_Cm.force_N));
        body->engine->applyTorque(ToBullet(F_Cm.torque_Nm));
        Apply(ImpulseSource::kOuter, body, p_WSo, dt_s * sign * pair.F_So_W.force_N,
              dt_s * sign * pair.F_So_W.torque_Nm);
      }
      pair.report.F_So_W = pair.F_So_W;
      pair.report.num_pushing = 1;
    }
  }

  void ApplyLoads(double dt_s) {
    for (RigidBody& body : bodies) {
      const core::Wrench& F = body.load_Bo_W;
      if (body.kind != BodyKind::kDynamic || (F.force_N == glm::dvec3(0.0) && F.torque_Nm == glm::dvec3(0.0))) continue;
      const glm::dvec3 p_WBo = body.X_WO().translation;
      const core::Wrench F_Cm = core::ShiftWrench(F, p_WBo - body.p_WCm);
      body.engine->applyCentralForce(ToBullet(F_Cm.force_N));
      body.engine->applyTorque(ToBullet(F_Cm.torque_Nm));
      Apply(ImpulseSource::kOuter, &body, p_WBo, dt_s * F.force_N, dt_s * F.torque_Nm);
    }
  }

  // m g at the centre of mass, in the books as any other impulse.
  void ApplyWeights(double dt_s) {
    if (gravity_W_m_per_s2 == glm::dvec3(0.0)) return;
    for (RigidBody& body : bodies) {
      if (body.kind != BodyKind::kDynamic) continue;
      const glm::dvec3 weight_N = body.mass_kg * gravity_W_m_per_s2;
      body.engine->applyCentralForce(ToBullet(weight_N));
      Apply(ImpulseSource::kOuter, &body, body.p_WCm, dt_s * weight_N, glm::dvec3(0.0));
    }
  }

  void Collect(double dt_s) {
    for (PairSlot& pair : pairs) {
      RigidBody& s = bodies[static_cast<std::size_t>(pair.sampled)];
      RigidBody& g = bodies[static_cast<std::size_t>(pair.field)];
      const glm::dvec3 p_WSo = s.X_WO().translation;
      pair.feed.Collect([&](const glm::dvec3& p_W, const glm::dvec3& impulse_W) {
        Apply(ImpulseSource::kContact, &s, p_W, impulse_W, glm::dvec3(0.0));
        Apply(ImpulseSource::kContact, &g, p_W, -impulse_W, glm::dvec3(0.0));
        pair.report.F_So_W.force_N += impulse_W / dt_s;
        pair.report.F_So_W.torque_Nm += glm::cross(p_W - p_WSo, impulse_W) / dt_s;
        ++pair.report.num_pushing;
      });
    }
    for (MechanismSlot& slot : mechanisms) {
      RigidBody& child = bodies[static_cast<std::size_t>(slot.child)];
      RigidBody& parent = bodies[static_cast<std::size_t>(slot.parent)];
      for (const Row& row : slot.mechanism->rows()) {
        if (!row.is_active || row.impulse == 0.0) continue;
        Apply(ImpulseSource::kJoint, &child, row.p_W, row.impulse * row.linear_W, row.impulse * row.angular_W);
        Apply(ImpulseSource::kJoint, &parent, row.p_W, -row.impulse * row.linear_W, -row.impulse * row.angular_W);
      }
      slot.mechanism->Finish(dt_s);
    }
  }

  void ExchangeState(Checkpoint* checkpoint) {
    for (std::size_t size : {bodies.size(), pairs.size(), mechanisms.size()}) checkpoint->Exchange(&size);
    for (RigidBody& body : bodies) body.ExchangeState(checkpoint);
    for (PairSlot& pair : pairs) {
      pair.feed.ExchangeState(checkpoint);
      checkpoint->Exchange(&pair.has_wrench);
      checkpoint->Exchange(&pair.is_muted);
      checkpoint->Exchange(&pair.F_So_W);
      checkpoint->Exchange(&pair.report);
    }
    for (MechanismSlot& slot : mechanisms) slot.mechanism->ExchangeState(checkpoint);
    solver.ExchangeState(checkpoint);
    checkpoint->Exchange(&num_steps);
    checkpoint->Exchange(&last_dt_s);
    checkpoint->Exchange(&magnitudes);
  }

  [[nodiscard]] BodyView View(int index) const {
    const RigidBody& b = bodies[static_cast<std::size_t>(index)];
    BodyView view{b.X_WO(), b.V_WO(), b.p_WCm, glm::dvec3(0.0)};
    if (b.kind == BodyKind::kDynamic) view.alpha_W = b.AngularVelocityOf(glm::cross(b.L_W, b.w_W));
    return view;
  }

  [[nodiscard]] ImpulseBalance BalanceOf(ImpulseSource source) const;
  [[nodiscard]] bool has_body(int index) const { return index >= 0 && static_cast<std::size_t>(index) < bodies.size(); }
  RigidBody& body(int index) { return bodies[static_cast<std::size_t>(index)]; }

  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher;
  btSimpleBroadphase broadphase;
  RowSolver solver;
  btSphereShape shape{0.01};  // required by Bullet, never used
  std::vector<RigidBody> bodies;
  btAlignedObjectArray<btCollisionObject*> collision_objects;
  std::vector<PairSlot> pairs;
  std::vector<MechanismSlot> mechanisms;
  int num_rows = 0;
  std::uint64_t num_steps = 0;
  double last_dt_s = 0.0;
  std::array<ImpulseMagnitude, kNumImpulseSources> magnitudes{};
  BulletWorld world;
  glm::dvec3 gravity_W_m_per_s2{0.0};
};

}  // namespace physics
