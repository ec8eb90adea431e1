#include "physics/hinge.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace physics {
namespace {

enum HingeRow : std::size_t { kX, kY, kZ, kTiltX, kTiltY, kAxis, kLower, kUpper, kLock, kNumRows };

// Part of a position error that a hard row removes per step. 1 would be exact for one row alone; less leaves room for
// the linearisation of the rotation.
constexpr double kErrorReduction = 0.3;

void SetHard(Row* row, const glm::dvec3& linear_W, const glm::dvec3& angular_W, const glm::dvec3& p_W, double bias) {
  row->is_active = true;
  row->is_hard = true;
  row->linear_W = linear_W;
  row->angular_W = angular_W;
  row->p_W = p_W;
  row->velocity_bias = bias;
}

}  // namespace

double DetentTorque(double theta_rad, double d0_rad, double d1_rad, double peak_Nm) {
  const double u = std::clamp((theta_rad - d0_rad) / (d1_rad - d0_rad), -0.25, 1.25);
  return -peak_Nm * std::sin(2.0 * std::numbers::pi * u);
}

core::Pose HingePose(const HingeParams& params, double angle_rad) {
  const core::Pose turn{core::QuaternionFromRotationVector({0.0, 0.0, angle_rad}), glm::dvec3(0.0)};
  return params.X_PJ * turn * params.X_CJ.inverse();
}

Hinge::Hinge(const HingeParams& params) : Mechanism(kNumRows), params_(params) {}

void Hinge::Prepare(const BodyView& parent, const BodyView& child, double dt_s) {
  const core::Pose X_WJp = parent.X_WO * params_.X_PJ;
  const core::Pose X_WJc = child.X_WO * params_.X_CJ;
  const glm::dvec3 p_W = X_WJc.translation;
  const glm::dvec3 error_W = X_WJc.translation - X_WJp.translation;
  const glm::dvec3 x_W = X_WJp.rotate({1, 0, 0});
  const glm::dvec3 y_W = X_WJp.rotate({0, 1, 0});
  const glm::dvec3 z_W = X_WJp.rotate({0, 0, 1});
  const glm::dvec3 zc_W = X_WJc.rotate({0, 0, 1});

  // Angle about z: the twist part of the relative rotation, in (-pi, pi].
  const glm::dquat relative = glm::conjugate(X_WJp.rotation) * X_WJc.rotation;
  double angle = 2.0 * std::atan2(relative.z, relative.w);
  if (angle > std::numbers::pi) angle -= 2.0 * std::numbers::pi;
  if (angle < -std::numbers::pi) angle += 2.0 * std::numbers::pi;
  position_ = angle;

  const double rate = kErrorReduction / dt_s;
  SetHard(&rows()[kX], x_W, glm::dvec3(0.0), p_W, -rate * glm::dot(x_W, error_W));
  SetHard(&rows()[kY], y_W, glm::dvec3(0.0), p_W, -rate * glm::dot(y_W, error_W));
  SetHard(&rows()[kZ], z_W, glm::dvec3(0.0), p_W, -rate * glm::dot(z_W, error_W));
  // Tilt of the child's z away from the parent's: rotation vector z_p x z_c for a small tilt.
  const glm::dvec3 tilt_W = glm::cross(z_W, zc_W);
  SetHard(&rows()[kTiltX], glm::dvec3(0.0), x_W, p_W, -rate * glm::dot(x_W, tilt_W));
  SetHard(&rows()[kTiltY], glm::dvec3(0.0), y_W, p_W, -rate * glm::dot(y_W, tilt_W));

  Row& axis = rows()[kAxis];
  SetAngularSpring(&axis, z_W, 0.0, 0.0, params_.damping_Nm_s_per_rad);
  if (params_.has_detents) {
    const double d0 = params_.detents_rad[0];
    const double d1 = params_.detents_rad[1];
    axis.force = DetentTorque(angle, d0, d1, params_.detent_torque_Nm);
    // Slope of the profile, -dT/dtheta, where it is stabilising.
    const double u = (angle - d0) / (d1 - d0);
    if (u > -0.25 && u < 1.25) {
      const double omega = 2.0 * std::numbers::pi / (d1 - d0);
      axis.stiffness = std::max(0.0, params_.detent_torque_Nm * omega * std::cos(2.0 * std::numbers::pi * u));
    }
    state_ = u < 0.5 ? 0 : 1;
  }

  // Limits: at the end of the step lower <= angle <= upper, pushing only back inside. While still inside, the row
  // stops the approach in time (bias = distance per step); beyond, it removes part of the violation.
  const double below = angle - params_.lower_rad;
  const double above = params_.upper_rad - angle;
  SetHard(&rows()[kLower], glm::dvec3(0.0), z_W, p_W, below > 0.0 ? -below / dt_s : -rate * below);
  rows()[kLower].lower = 0.0;
  SetHard(&rows()[kUpper], glm::dvec3(0.0), -z_W, p_W, above > 0.0 ? -above / dt_s : -rate * above);
  rows()[kUpper].lower = 0.0;

  rows()[kLock].is_active = false;
  if (params_.is_stuck) {
    if (!has_lock_angle_) {
      has_lock_angle_ = true;
      lock_angle_rad_ = angle;
    }
    SetHard(&rows()[kLock], glm::dvec3(0.0), z_W, p_W, -rate * (angle - lock_angle_rad_));
  }
}

void Hinge::Finish(double dt_s) {
  force_ = (rows()[kAxis].impulse + rows()[kLower].impulse - rows()[kUpper].impulse + rows()[kLock].impulse) / dt_s;
}

void Hinge::ExchangeState(Checkpoint* checkpoint) {
  Mechanism::ExchangeState(checkpoint);
  checkpoint->Exchange(&params_);
  checkpoint->Exchange(&has_lock_angle_);
  checkpoint->Exchange(&lock_angle_rad_);
}

}  // namespace physics
