#include "physics/spring_coupling.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

constexpr double kNothing = 1e-12;  // N and Nm: a grip that holds nothing

glm::dvec3 VelocityAt(const BodyView& body, const glm::dvec3& p_W) {
  return body.V_WO.linear_m_per_s + glm::cross(body.V_WO.angular_rad_per_s, p_W - body.X_WO.translation);
}

glm::dvec3 AnyAcross(const glm::dvec3& n) {
  const glm::dvec3 other = std::abs(n.x) < 0.6 ? glm::dvec3(1.0, 0.0, 0.0) : glm::dvec3(0.0, 1.0, 0.0);
  return glm::normalize(glm::cross(n, other));
}

// What remains of a force f and a torque tau.
struct GripShare {
  double force = 1.0;
  double torque = 1.0;
};

// The closest point of the limit surface, in the energy of springs k and k_t: slip then is along the surface's normal,
// which is what dissipates most. From the minimum of (f' - f)^2 / k + (tau' - tau)^2 / k_t with multiplier l,
//   f' = f / (1 + l k / F^2),  tau' = tau / (1 + l k_t / T^2),
// and the surface's equation falls with l.
GripShare Project(const GripLimit& limit, double k, double k_t, double f, double tau) {
  const double F = std::max(limit.force_N, kNothing), T = std::max(limit.torque_Nm, kNothing);
  const double a = k / (F * F), b = k_t / (T * T);
  const auto shares = [&](double l) { return GripShare{1.0 / (1.0 + l * a), 1.0 / (1.0 + l * b)}; };
  const auto level = [&](const GripShare& at) { return std::hypot(at.force * f / F, at.torque * tau / T); };
  if (level({}) <= 1.0) return {};
  double low = 0.0, high = level({}) / std::min(a, b);  // there both are at most their limit's share of the level
  constexpr int kHalvings = 50;                         // to 1e-15 of the first bound
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (level(shares(middle)) > 1.0 ? low : high) = middle;
  }
  return shares(high);
}

void LimitRow(Row* row, double most) {
  row->lower = -most;
  row->upper = most;
}

// The other of two coordinates on the unit circle.
double Beside(double share) {
  return std::sqrt(std::max(0.0, 1.0 - share * share));
}

}  // namespace

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

void SpringCoupling::Prepare(const BodyView& parent, const BodyView& child, double dt_s) {
  if (!is_attached_) return;
  p_WPo_ = parent.X_WO.translation;
  if (limit_) {
    Slip(parent, child);
    HoldWithinLimit(parent, child, dt_s);
  } else {
    HoldEverything(parent, child);
  }
  deflection_P_m_ = glm::conjugate(parent.X_WO.rotation) * Offset_W(parent, child);
}

void SpringCoupling::HoldEverything(const BodyView& parent, const BodyView& child) {
  const glm::dvec3 p_W = child.X_WO * p_CGrip_m_;
  const glm::dvec3 offset_W = Offset_W(parent, child);
  const glm::dvec3 turn_W = Turn_W(parent, child);
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 axis_W(0.0);
    axis_W[axis] = 1.0;
    const auto i = static_cast<std::size_t>(axis);
    SetSpring(&rows()[i], axis_W, p_W, offset_W[axis], params_.stiffness_N_per_m, params_.damping_N_s_per_m);
    SetAngularSpring(&rows()[3 + i], axis_W, turn_W[axis], params_.stiffness_Nm_per_rad, params_.damping_Nm_s_per_rad);
  }
}

// What the springs have beyond the limit goes from the child's grip point and into its wanted attitude.
void SpringCoupling::Slip(const BodyView& parent, const BodyView& child) {
  const glm::dvec3 n_W = parent.X_WO.rotate(limit_->axis_P);
  const glm::dvec3 offset_W = Offset_W(parent, child);
  const glm::dvec3 across_W = offset_W - glm::dot(offset_W, n_W) * n_W;
  const double turn = glm::dot(Turn_W(parent, child), n_W);
  const GripShare kept =
      Project(*limit_, params_.stiffness_N_per_m, params_.stiffness_Nm_per_rad,
              params_.stiffness_N_per_m * glm::length(across_W), params_.stiffness_Nm_per_rad * std::abs(turn));
  if (kept.force == 1.0 && kept.torque == 1.0) return;
  p_CGrip_m_ -= glm::conjugate(child.X_WO.rotation) * ((1.0 - kept.force) * across_W);
  X_PC_.rotation =
      glm::normalize(core::QuaternionFromRotationVector((1.0 - kept.torque) * turn * limit_->axis_P) * X_PC_.rotation);
}

// The rows lie along n, the force f across it that springs and dampers would make at the end of the step, and n x f.
// Force and torque are each limited to what the other's projection on the limit surface leaves.
void SpringCoupling::HoldWithinLimit(const BodyView& parent, const BodyView& child, double dt_s) {
  const glm::dvec3 p_W = child.X_WO * p_CGrip_m_;
  const glm::dvec3 n_W = parent.X_WO.rotate(limit_->axis_P);
  const glm::dvec3 offset_W = Offset_W(parent, child);
  const glm::dvec3 turn_W = Turn_W(parent, child);
  const glm::dvec3 v_W = VelocityAt(child, p_W) - VelocityAt(parent, p_W);
  const glm::dvec3 w_W = child.V_WO.angular_rad_per_s - parent.V_WO.angular_rad_per_s;
  const double slope_N_s_per_m = params_.stiffness_N_per_m * dt_s + params_.damping_N_s_per_m;
  const double slope_Nm_s_per_rad = params_.stiffness_Nm_per_rad * dt_s + params_.damping_Nm_s_per_rad;
  const glm::dvec3 F_W = params_.stiffness_N_per_m * offset_W + slope_N_s_per_m * v_W;
  const glm::dvec3 f_W = F_W - glm::dot(F_W, n_W) * n_W;
  const double f_N = glm::length(f_W);
  const double tau_Nm = std::abs(glm::dot(params_.stiffness_Nm_per_rad * turn_W + slope_Nm_s_per_rad * w_W, n_W));
  const glm::dvec3 along_W = f_N > 0.0 ? f_W / f_N : AnyAcross(n_W);
  const glm::dvec3 axes_W[3] = {n_W, along_W, glm::cross(n_W, along_W)};
  for (std::size_t i = 0; i < 3; ++i) {
    SetSpring(&rows()[i], axes_W[i], p_W, glm::dot(offset_W, axes_W[i]), params_.stiffness_N_per_m,
              params_.damping_N_s_per_m);
    SetAngularSpring(&rows()[3 + i], axes_W[i], glm::dot(turn_W, axes_W[i]), params_.stiffness_Nm_per_rad,
                     params_.damping_Nm_s_per_rad);
  }
  const GripShare kept = Project(*limit_, slope_N_s_per_m / dt_s, slope_Nm_s_per_rad / dt_s, f_N, tau_Nm);
  const double of_force = std::min(1.0, kept.force * f_N / std::max(limit_->force_N, kNothing));
  const double of_torque = std::min(1.0, kept.torque * tau_Nm / std::max(limit_->torque_Nm, kNothing));
  LimitRow(&rows()[1], limit_->force_N * Beside(of_torque));
  LimitRow(&rows()[2], limit_->force_N * Beside(std::min(1.0, std::hypot(of_force, of_torque))));
  LimitRow(&rows()[3], limit_->torque_Nm * Beside(of_force));
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
  if (limit_) checkpoint->Exchange(&*limit_);  // had from the start, or never
  checkpoint->Exchange(&X_PC_);
  checkpoint->Exchange(&p_PGrip_m_);
  checkpoint->Exchange(&p_CGrip_m_);
  checkpoint->Exchange(&p_WPo_);
  checkpoint->Exchange(&deflection_P_m_);
  checkpoint->Exchange(&F_Po_W_);
}

}  // namespace physics
