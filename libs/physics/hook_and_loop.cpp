#include "physics/hook_and_loop.hpp"

namespace physics {

HookAndLoop::HookAndLoop(const HookAndLoopParams& params)
    : Mechanism(3 * params.p_PPatch_m.size()), params_(params), is_held_(params.p_PPatch_m.size(), true) {
  const core::Pose X_CP = params.X_PC.inverse();
  for (const glm::dvec3& p_P : params.p_PPatch_m) p_CPatch_m_.push_back(X_CP * p_P);
  state_ = static_cast<int>(is_held_.size());
  position_ = state_;
  AddTunable("release_force_N", &params_.release_force_N);
  AddTunable("stiffness_N_per_m", &params_.stiffness_N_per_m);
  AddTunable("damping", &params_.damping_N_s_per_m);
}

void HookAndLoop::Prepare(const BodyView& parent, const BodyView& child, double /*dt_s*/) {
  for (std::size_t i = 0; i < is_held_.size(); ++i) {
    const glm::dvec3 p_WPatch = child.X_WO * p_CPatch_m_[i];
    const glm::dvec3 offset_W = p_WPatch - parent.X_WO * params_.p_PPatch_m[i];
    if (is_held_[i] && params_.stiffness_N_per_m * glm::length(offset_W) > params_.release_force_N) {
      is_held_[i] = false;
      --state_;
    }
    for (int axis = 0; axis < 3; ++axis) {
      Row& row = rows()[3 * i + static_cast<std::size_t>(axis)];
      if (!is_held_[i]) {
        row.is_active = false;
        continue;
      }
      glm::dvec3 axis_W(0.0);
      axis_W[axis] = 1.0;
      SetSpring(&row, axis_W, p_WPatch, offset_W[axis], params_.stiffness_N_per_m, params_.damping_N_s_per_m);
    }
  }
  position_ = state_;
}

void HookAndLoop::Finish(double dt_s) {
  glm::dvec3 sum(0.0);
  for (const Row& row : rows()) {
    if (row.is_active) sum += row.impulse * row.linear_W;
  }
  force_ = glm::length(sum) / dt_s;
}

double HookAndLoop::StoredEnergy_J(const BodyView& parent, const BodyView& child) const {
  double energy_J = 0.0;
  for (std::size_t i = 0; i < is_held_.size(); ++i) {
    if (!is_held_[i]) continue;
    const glm::dvec3 offset_W = child.X_WO * p_CPatch_m_[i] - parent.X_WO * params_.p_PPatch_m[i];
    energy_J += 0.5 * params_.stiffness_N_per_m * glm::dot(offset_W, offset_W);
  }
  return energy_J;
}

void HookAndLoop::ExchangeState(Checkpoint* checkpoint) {
  Mechanism::ExchangeState(checkpoint);
  for (std::size_t i = 0; i < is_held_.size(); ++i) {
    bool is_held = is_held_[i];
    checkpoint->Exchange(&is_held);
    is_held_[i] = is_held;
  }
}

}  // namespace physics
