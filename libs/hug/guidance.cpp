#include "hug/guidance.hpp"

#include <algorithm>

namespace hug {
namespace {

constexpr double kSameGoal_m = 0.02;
constexpr double kSameGoal_rad = 0.1;
constexpr double kPeakOfLeastJerk = 1.875;  // peak over mean speed
constexpr double kShortest_s = 0.4;

core::Twist WayBetween(const core::Pose& from, const core::Pose& to) {
  return {core::RotationVector(to.rotation * glm::conjugate(from.rotation)), to.translation - from.translation};
}

glm::dvec3 Shortened(const glm::dvec3& v, double longest) {
  const double length = glm::length(v);
  return length > longest ? (longest / length) * v : v;
}

}  // namespace

core::Wrench Within(const core::Wrench& F, double max_force_N, double max_torque_Nm) {
  return {Shortened(F.force_N, max_force_N), Shortened(F.torque_Nm, max_torque_Nm)};
}

void Guidance::LeadTo(const core::Pose& X_WG) {
  goal_ = X_WG;
  if (!path_) return;
  const core::Twist moved = WayBetween(path_->X_WZ, X_WG);
  if (glm::length(moved.linear_m_per_s) > kSameGoal_m || glm::length(moved.angular_rad_per_s) > kSameGoal_rad) {
    path_.reset();
  } else {
    path_->X_WZ = X_WG;
  }
}

void Guidance::Stop() {
  goal_.reset();
  path_.reset();
}

void Guidance::Begin(const core::Pose& X_WD) {
  const core::Twist way = WayBetween(X_WD, *goal_);
  const double duration_s = kPeakOfLeastJerk * std::max(glm::length(way.linear_m_per_s) / figures_.speed_m_per_s,
                                                        glm::length(way.angular_rad_per_s) / figures_.speed_rad_per_s);
  path_ = Interpolator{X_WD, *goal_, std::max(duration_s, kShortest_s)};
  time_s_ = 0.0;
}

void Guidance::GoOn(double dt_s, const core::Pose& X_WD) {
  const core::Twist off = WayBetween(X_WD, path_->X_WI(time_s_));
  const double share = std::max(glm::length(off.linear_m_per_s) / figures_.wait_m,
                                glm::length(off.angular_rad_per_s) / figures_.wait_rad);
  const double rate = std::max(0.0, 1.0 - share);
  time_s_ = std::min(time_s_ + rate * dt_s, path_->duration_s);
  X_WI_ = path_->X_WI(time_s_);
  V_WI_ = path_->V_WI(time_s_);
  V_WI_.linear_m_per_s *= rate;
  V_WI_.angular_rad_per_s *= rate;
}

// F = K (X_I - X_D), no more than the limit, + B (V_I - V_D), and no more than it again: so a hand that comes back from
// far away does so at no more than the limit over B.
core::Wrench Guidance::Step(double dt_s, const core::Pose& X_WD, const core::Twist& V_WD) {
  if (!goal_) return {};
  if (!path_) Begin(X_WD);
  GoOn(dt_s, X_WD);
  const core::Twist off = WayBetween(X_WD, X_WI_);
  core::Wrench F =
      Within({figures_.stiffness_N_per_m * off.linear_m_per_s, figures_.stiffness_Nm_per_rad * off.angular_rad_per_s},
             figures_.max_force_N, figures_.max_torque_Nm);
  F.force_N += figures_.damping_N_s_per_m * (V_WI_.linear_m_per_s - V_WD.linear_m_per_s);
  F.torque_Nm += figures_.damping_Nm_s_per_rad * (V_WI_.angular_rad_per_s - V_WD.angular_rad_per_s);
  return Within(F, figures_.max_force_N, figures_.max_torque_Nm);
}

}  // namespace hug
