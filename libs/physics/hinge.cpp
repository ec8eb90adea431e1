#include "physics/hinge.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace physics {
namespace {

enum HingeRow : std::size_t { kHingeX, kHingeY, kHingeZ, kTiltX, kTiltY };

// Rotation angle about z, 2 atan2(q_z, q_w): the twist of the swing-twist decomposition, in (-pi, pi].
double AngleAbout_z(const glm::dquat& R_JpJc) {
  double angle = 2.0 * std::atan2(R_JpJc.z, R_JpJc.w);
  if (angle > std::numbers::pi) angle -= 2.0 * std::numbers::pi;
  if (angle < -std::numbers::pi) angle += 2.0 * std::numbers::pi;
  return angle;
}

}  // namespace

double DetentTorque(double theta_rad, double d0_rad, double d1_rad, double peak_Nm) {
  const double u = std::clamp((theta_rad - d0_rad) / (d1_rad - d0_rad), -0.25, 1.25);
  return -peak_Nm * std::sin(2.0 * std::numbers::pi * u);
}

double DetentEnergy_J(double theta_rad, double d0_rad, double d1_rad, double peak_Nm) {
  const double period = d1_rad - d0_rad;
  const double u = (theta_rad - d0_rad) / period;
  const double within = std::clamp(u, -0.25, 1.25);
  return peak_Nm * period *
         ((1.0 - std::cos(2.0 * std::numbers::pi * within)) / (2.0 * std::numbers::pi) + std::abs(u - within));
}

core::Pose HingePose(const HingeParams& params, double angle_rad) {
  const core::Pose turn{core::QuaternionFromRotationVector({0.0, 0.0, angle_rad}), glm::dvec3(0.0)};
  return params.X_PJ * turn * params.X_CJ.inverse();
}

Hinge::Hinge(const HingeParams& params) : Mechanism(kFirstAxisRow + JointAxis::kNumRows), params_(params) {
  AddTunable("damping", &params_.axis.damping);
  AddTunable("locked", &params_.axis.locked);
  AddTunable("motor_rad_per_s", &params_.axis.motor_speed, true);
  AddTunable("motor_torque_Nm", &params_.axis.motor_limit);
  if (params_.has_detents) AddTunable("detent_torque_Nm", &params_.detent_torque_Nm);
}

void Hinge::Prepare(const BodyView& parent, const BodyView& child, double dt_s) {
  const core::Pose X_WJp = parent.X_WO * params_.X_PJ;
  const core::Pose X_WJc = child.X_WO * params_.X_CJ;
  const glm::dvec3 p_W = X_WJc.translation;
  const glm::dvec3 error_W = X_WJc.translation - X_WJp.translation;
  const glm::dvec3 x_W = X_WJp.rotate({1, 0, 0});
  const glm::dvec3 y_W = X_WJp.rotate({0, 1, 0});
  const glm::dvec3 z_W = X_WJp.rotate({0, 0, 1});
  const glm::dvec3 zc_W = X_WJc.rotate({0, 0, 1});
  const double angle = AngleAbout_z(glm::conjugate(X_WJp.rotation) * X_WJc.rotation);
  position_ = angle;

  // The anchors coincide at the end of the step: their distance e [m] satisfies e + dt e' + dt^2 e'' / 2 = 0, with e'
  // the row's speed at the end. So e' = -e / dt - dt e'' / 2 (SHAKE).
  const double rate = kErrorReduction / dt_s;
  const glm::dvec3 curvature_W =
      PointAcceleration(child, p_W - child.p_WCm) - PointAcceleration(parent, X_WJp.translation - parent.p_WCm);
  const auto point_bias = [&](const glm::dvec3& axis_W) {
    return -rate * glm::dot(axis_W, error_W) - 0.5 * dt_s * glm::dot(axis_W, curvature_W);
  };
  SetHard(&rows()[kHingeX], x_W, glm::dvec3(0.0), p_W, point_bias(x_W));
  SetHard(&rows()[kHingeY], y_W, glm::dvec3(0.0), p_W, point_bias(y_W));
  SetHard(&rows()[kHingeZ], z_W, glm::dvec3(0.0), p_W, point_bias(z_W));

  // Tilt of the child's z axis relative to the parent's: t = z_p x z_c, the rotation vector to first order. Its second
  // derivative is z_p'' x z_c + 2 z_p' x z_c' + z_p x z_c'', where an axis moves like a point at its tip.
  const glm::dvec3 tilt_W = glm::cross(z_W, zc_W);
  const glm::dvec3 tilt_curvature_W =
      glm::cross(PointAcceleration(parent, z_W), zc_W) +
      2.0 * glm::cross(glm::cross(parent.V_WO.angular_rad_per_s, z_W), glm::cross(child.V_WO.angular_rad_per_s, zc_W)) +
      glm::cross(z_W, PointAcceleration(child, zc_W));
  const auto tilt_bias = [&](const glm::dvec3& axis_W) {
    return -rate * glm::dot(axis_W, tilt_W) - 0.5 * dt_s * glm::dot(axis_W, tilt_curvature_W);
  };
  SetHard(&rows()[kTiltX], glm::dvec3(0.0), x_W, p_W, tilt_bias(x_W));
  SetHard(&rows()[kTiltY], glm::dvec3(0.0), y_W, p_W, tilt_bias(y_W));

  axis_.Prepare(params_.axis, axis_rows(), glm::dvec3(0.0), z_W, p_W, angle, dt_s);
  if (!params_.has_detents) return;
  Row& axis = axis_rows()[0];
  axis.is_active = true;
  const double d0 = params_.detents_rad[0];
  const double d1 = params_.detents_rad[1];
  axis.force = DetentTorque(angle, d0, d1, params_.detent_torque_Nm);
  // Stiffness -dT/dtheta = T_peak omega cos(2 pi u), omega = 2 pi / (d1 - d0), where it is positive (stable).
  const double u = (angle - d0) / (d1 - d0);
  if (u > -0.25 && u < 1.25) {
    const double omega = 2.0 * std::numbers::pi / (d1 - d0);
    axis.stiffness = std::max(0.0, params_.detent_torque_Nm * omega * std::cos(2.0 * std::numbers::pi * u));
  }
  state_ = u < 0.5 ? 0 : 1;
}

void Hinge::Finish(double dt_s) {
  force_ = JointAxis::Force(axis_rows(), dt_s);
}

double Hinge::StoredEnergy_J(const BodyView& parent, const BodyView& child) const {
  if (!params_.has_detents) return 0.0;
  const glm::dquat R_JpJc =
      glm::conjugate((parent.X_WO * params_.X_PJ).rotation) * (child.X_WO * params_.X_CJ).rotation;
  return DetentEnergy_J(AngleAbout_z(R_JpJc), params_.detents_rad[0], params_.detents_rad[1], params_.detent_torque_Nm);
}

void Hinge::SetServoTarget(double angle_rad) {
  params_.axis.servo_target = std::clamp(angle_rad, params_.axis.lower, params_.axis.upper);
}

void Hinge::ExchangeState(Checkpoint* checkpoint) {
  Mechanism::ExchangeState(checkpoint);
  axis_.ExchangeState(checkpoint);
  checkpoint->Exchange(&params_.axis.servo_target);
}

}  // namespace physics
