#pragma once

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <memory>

#include "core/pose.hpp"
#include "core/wrench.hpp"
#include "physics/engine/impulse_account.hpp"
#include "physics/world.hpp"

namespace physics {

// State of a body beside Bullet's. B is the body frame: origin at the centre of mass Cm, axes along the principal axes
// of inertia. The state is the angular momentum rather than the angular velocity, as a free body conserves the former.
struct RigidBody {
  BodyKind kind = BodyKind::kFixed;
  double mass_kg = 0.0;
  glm::dvec3 moments_kg_m2{1.0};
  core::Pose X_OB;
  core::Pose X_BO;

  glm::dvec3 p_WCm{0.0};
  glm::dquat R_WB{1.0, 0.0, 0.0, 0.0};
  glm::dvec3 v_WCm{0.0};
  glm::dvec3 L_W{0.0};     // about Cm
  glm::dvec3 w_W{0.0};     // given for kinematic bodies, else I^-1 L
  core::Wrench load_Bo_W;  // external, about the mesh origin

  // For ImpulseBalance.
  glm::dvec3 start_p_Ns{0.0};
  glm::dvec3 start_L_Nms{0.0};
  glm::dvec3 impulses_Ns{0.0};
  glm::dvec3 angular_impulses_Nms{0.0};  // about the world origin
  ImpulseAccount account;

  std::unique_ptr<btRigidBody> engine;

  [[nodiscard]] core::Pose X_WO() const { return core::Pose{R_WB, p_WCm} * X_BO; }
  [[nodiscard]] core::Twist V_WO() const { return {w_W, v_WCm + glm::cross(w_W, R_WB * X_BO.translation)}; }
  [[nodiscard]] glm::dvec3 InertiaTimes(const glm::dvec3& w) const {
    return R_WB * (moments_kg_m2 * (glm::conjugate(R_WB) * w));
  }
  [[nodiscard]] glm::dvec3 AngularVelocityOf(const glm::dvec3& L) const {
    return R_WB * ((glm::conjugate(R_WB) * L) / moments_kg_m2);
  }
  [[nodiscard]] glm::dvec3 momentum_Ns() const { return mass_kg * v_WCm; }
  [[nodiscard]] glm::dvec3 angular_momentum_Nms() const { return L_W + glm::cross(p_WCm, momentum_Ns()); }
  [[nodiscard]] double kinetic_energy_J() const {
    return 0.5 * mass_kg * glm::dot(v_WCm, v_WCm) + 0.5 * glm::dot(AngularVelocityOf(L_W), L_W);
  }

  void ExchangeState(Checkpoint* checkpoint) {
    for (glm::dvec3* v : {&p_WCm, &v_WCm, &L_W, &w_W, &start_p_Ns, &start_L_Nms, &impulses_Ns, &angular_impulses_Nms}) {
      checkpoint->Exchange(v);
    }
    checkpoint->Exchange(&R_WB);
    account.ExchangeState(checkpoint);
    checkpoint->Exchange(&load_Bo_W);
  }
  // Copies pose and velocity to the solver's body; mesh-frame pose and twist for bodies that are not dynamic.
  void Push() const;
  // Takes the solver's velocities and integrates the pose over one step.
  void Integrate(double dt_s);
};

}  // namespace physics
