#include "physics/spring_coupling.hpp"

namespace physics {

SpringCoupling::SpringCoupling(const SpringCouplingParams& params) : Mechanism(6), params_(params) {
  AddTunable("stiffness_N_per_m", &params_.stiffness_N_per_m);
  AddTunable("damping_N_s_per_m", &params_.damping_N_s_per_m);
  AddTunable("stiffness_Nm_per_rad", &params_.stiffness_Nm_per_rad);
  AddTunable("damping_Nm_s_per_rad", &params_.damping_Nm_s_per_rad);
}

glm::dvec3 SpringCoupling::Offset_W(const BodyView& parent, const BodyView& child) const {
  return child.X_WO * p_CGrip_m_ - parent.X_WO * p_PGrip_m_;
}

// Rotation vector from the child's target pose (X_WP X_PC) to its pose, in W [rad].
glm::dvec3 SpringCoupling::Turn_W(const BodyView& parent, const BodyView& child) const {
  const glm::dquat wanted = parent.X_WO.rotation * X_PC_.rotation;
  return core::RotationVector(child.X_WO.rotation * glm::conjugate(wanted));
}

void SpringCoupling::Attach(const core::Pose& X_WParent, const core::Pose& X_WChild, const glm::dvec3& p_W) {
  is_attached_ = true;
  state_ = 1;
  X_PC_ = X_WParent.inverse() * X_WChild;
  p_PGrip_m_ = X_WParent.inverse() * p_W;
  p_CGrip_m_ = X_WChild.inverse() * p_W;
  deflection_P_m_ = glm::dvec3(0.0);
}

void SpringCoupling::Detach() {
  is_attached_ = false;
  state_ = 0;
  DeactivateAll();
  F_Po_W_ = {};
  deflection_P_m_ = glm::dvec3(0.0);
}

void SpringCoupling::Prepare(const BodyView& parent, const BodyView& child, double /*dt_s*/) {
  if (!is_attached_) return;
  p_WPo_ = parent.X_WO.translation;
  const glm::dvec3 p_W = child.X_WO * p_CGrip_m_;
  const glm::dvec3 offset_W = Offset_W(parent, child);
  deflection_P_m_ = glm::conjugate(parent.X_WO.rotation) * offset_W;
  const glm::dvec3 turn_W = Turn_W(parent, child);
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 axis_W(0.0);
    axis_W[axis] = 1.0;
    const auto i = static_cast<std::size_t>(axis);
    SetSpring(&rows()[i], axis_W, p_W, offset_W[axis], params_.stiffness_N_per_m, params_.damping_N_s_per_m);
    SetAngularSpring(&rows()[3 + i], axis_W, turn_W[axis], params_.stiffness_Nm_per_rad, params_.damping_Nm_s_per_rad);
  }
}

void SpringCoupling::Finish(double dt_s) {
  F_Po_W_ = {};
  if (!is_attached_) return;
  // Rows act on the child; the parent receives the opposite at the same point.
  for (const Row& row : rows()) {
    const glm::dvec3 impulse_W = row.impulse * row.linear_W;
    F_Po_W_.force_N -= impulse_W / dt_s;
    F_Po_W_.torque_Nm -= (glm::cross(row.p_W - p_WPo_, impulse_W) + row.impulse * row.angular_W) / dt_s;
  }
  force_ = glm::length(F_Po_W_.force_N);
}

double SpringCoupling::StoredEnergy_J(const BodyView& parent, const BodyView& child) const {
  if (!is_attached_) return 0.0;
  const glm::dvec3 offset_W = Offset_W(parent, child);
  const glm::dvec3 turn_W = Turn_W(parent, child);
  return 0.5 * (params_.stiffness_N_per_m * glm::dot(offset_W, offset_W) +
                params_.stiffness_Nm_per_rad * glm::dot(turn_W, turn_W));
}

void SpringCoupling::ExchangeState(Checkpoint* checkpoint) {
  Mechanism::ExchangeState(checkpoint);
  checkpoint->Exchange(&is_attached_);
  checkpoint->Exchange(&X_PC_);
  checkpoint->Exchange(&p_PGrip_m_);
  checkpoint->Exchange(&p_CGrip_m_);
  checkpoint->Exchange(&p_WPo_);
  checkpoint->Exchange(&deflection_P_m_);
  checkpoint->Exchange(&F_Po_W_);
}

}  // namespace physics
