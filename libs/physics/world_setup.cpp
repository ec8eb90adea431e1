// Setup of a world: bodies, contact pairs and mechanisms.

#include <string>

#include "physics/engine/world_impl.hpp"

namespace physics {

core::Result<int> World::AddBody(const BodyParams& params) {
  Impl& w = *impl_;
  const std::string name = "body " + std::to_string(w.bodies.size());
  if (w.bodies.size() >= static_cast<std::size_t>(kMaxBodies)) {
    return core::Fail(core::ErrorCode::kResource, name + ": a world holds at most 512 bodies; split the scenario");
  }
  RigidBody body;
  body.kind = params.kind;
  btScalar mass = 0.0;
  btVector3 moments(0, 0, 0);
  if (params.kind == BodyKind::kDynamic) {
    if (!IsPhysical(params.mass)) {
      return core::Fail(
          core::ErrorCode::kInvalidInput,
          name + ": mass or inertia is not that of a real body (mass " + std::to_string(params.mass.mass_kg) +
              " kg; moments must be positive and satisfy the triangle inequality); close the mesh, or give "
              "another density or mass");
    }
    const PrincipalInertia principal = DiagonalizeInertia(params.mass.I_Cm_O_kg_m2);
    body.mass_kg = params.mass.mass_kg;
    body.moments_kg_m2 = principal.moments_kg_m2;
    body.X_OB = {principal.R_OB, params.mass.p_OCm_m};
    mass = body.mass_kg;
    moments = ToBullet(body.moments_kg_m2);
  }
  body.X_BO = body.X_OB.inverse();
  const core::Pose X_WB = params.X_WO * body.X_OB;
  body.p_WCm = X_WB.translation;
  body.R_WB = X_WB.rotation;
  if (params.kind != BodyKind::kFixed) {
    body.w_W = params.V_WO.angular_rad_per_s;
    body.v_WCm = core::PointVelocity(params.V_WO, params.X_WO.rotate(body.X_OB.translation));
  }
  if (params.kind == BodyKind::kDynamic) body.L_W = body.InertiaTimes(body.w_W);
  body.start_p_Ns = body.momentum_Ns();
  body.start_L_Nms = body.angular_momentum_Nms();

  btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, &w.shape, moments);
  info.m_linearSleepingThreshold = 0.0;
  info.m_angularSleepingThreshold = 0.0;
  body.engine = std::make_unique<btRigidBody>(info);
  body.engine->setActivationState(DISABLE_DEACTIVATION);
  body.engine->setFlags(0);  // no gyroscopic term, as Integrate includes it
  body.engine->setDamping(0.0, 0.0);
  if (params.kind == BodyKind::kKinematic) {
    int flags = body.engine->getCollisionFlags() & ~btCollisionObject::CF_STATIC_OBJECT;
    body.engine->setCollisionFlags(flags | btCollisionObject::CF_KINEMATIC_OBJECT);
  }
  body.Push();
  w.world.addRigidBody(body.engine.get(), 0, 0);
  w.collision_objects.push_back(body.engine.get());
  w.bodies.push_back(std::move(body));
  w.solver.Reserve(static_cast<int>(w.bodies.size()), 0, 0);
  return static_cast<int>(w.bodies.size()) - 1;
}

core::Result<int> World::AddContactPair(int sampled_body, int field_body, ContactKind kind) {
  Impl& w = *impl_;
  if (!w.has_body(sampled_body) || !w.has_body(field_body) || sampled_body == field_body) {
    return core::Fail(core::ErrorCode::kInvalidInput, "contact pair: needs two different bodies of this world");
  }
  w.pairs.push_back(
      PairSlot{sampled_body, field_body,
               ContactFeed(&w.dispatcher, w.body(sampled_body).engine.get(), w.body(field_body).engine.get(), kind),
               false, false, core::Wrench{}, ContactReport{}});
  w.solver.Reserve(0, static_cast<int>(w.pairs.size() * core::kMaxContactPlanes), 0);
  return static_cast<int>(w.pairs.size()) - 1;
}

core::Result<int> World::AddMechanism(int parent_body, int child_body, std::unique_ptr<Mechanism> mechanism) {
  Impl& w = *impl_;
  if (!w.has_body(parent_body) || !w.has_body(child_body) || parent_body == child_body) {
    return core::Fail(core::ErrorCode::kInvalidInput, "mechanism: needs two different bodies of this world");
  }
  if (w.body(parent_body).kind != BodyKind::kDynamic && w.body(child_body).kind != BodyKind::kDynamic) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "mechanism: neither parent nor child can move; give one of them owner=\"physics\"");
  }
  MechanismSlot slot;
  slot.parent = parent_body;
  slot.child = child_body;
  slot.mechanism = std::move(mechanism);
  slot.constraint =
      std::make_unique<RowConstraint>(*w.body(child_body).engine, *w.body(parent_body).engine, slot.mechanism.get());
  w.num_rows += static_cast<int>(slot.mechanism->rows().size());
  w.world.addConstraint(slot.constraint.get(), true);
  w.mechanisms.push_back(std::move(slot));
  w.solver.Reserve(0, 0, w.num_rows);
  return static_cast<int>(w.mechanisms.size()) - 1;
}

}  // namespace physics
