#pragma once

#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

namespace core {

// Rigid transform X_AB: pose of frame B in frame A. Rotation is a unit quaternion R_AB, translation p_AB in metres.
// Adjacent letters cancel: X_AC = X_AB * X_BC, p_AQ = X_AB * p_BQ.
struct Pose {
  glm::dquat rotation{1.0, 0.0, 0.0, 0.0};  // w, x, y, z
  glm::dvec3 translation{0.0};

  [[nodiscard]] Pose inverse() const {
    const glm::dquat conjugate = glm::conjugate(rotation);
    return {conjugate, -(conjugate * translation)};
  }
  [[nodiscard]] glm::dvec3 rotate(const glm::dvec3& v_B) const { return rotation * v_B; }
};

inline Pose operator*(const Pose& X_AB, const Pose& X_BC) {
  return {glm::normalize(X_AB.rotation * X_BC.rotation), X_AB.rotation * X_BC.translation + X_AB.translation};
}
inline glm::dvec3 operator*(const Pose& X_AB, const glm::dvec3& p_BQ) {
  return X_AB.rotation * p_BQ + X_AB.translation;
}

// Rotation vector phi (axis times angle, rad, angle in [0, pi]) of a unit quaternion q = (w, v): the SO(3) logarithm,
//   phi = 2 atan2(|v|, w) v / |v|,   with w >= 0 (q and -q are the same rotation).
// The factor tends to 2 as |v| -> 0. Below 1e-12 the limit replaces the division: its error is of order |v|^3 there.
inline glm::dvec3 RotationVector(glm::dquat q) {
  if (q.w < 0.0) q = -q;
  const glm::dvec3 v(q.x, q.y, q.z);
  const double norm = glm::length(v);
  if (norm < 1e-12) return 2.0 * v;
  return (2.0 * std::atan2(norm, q.w) / norm) * v;
}

// Unit quaternion of a rotation vector phi [rad]: the SO(3) exponential,
//   q = (cos(|phi| / 2), sin(|phi| / 2) phi / |phi|).   Below 1e-12 rad its first-order expansion (1, phi / 2).
inline glm::dquat QuaternionFromRotationVector(const glm::dvec3& phi) {
  const double angle = glm::length(phi);
  if (angle < 1e-12) return glm::normalize(glm::dquat(1.0, 0.5 * phi.x, 0.5 * phi.y, 0.5 * phi.z));
  const glm::dvec3 v = (std::sin(0.5 * angle) / angle) * phi;
  return {std::cos(0.5 * angle), v.x, v.y, v.z};
}

// Roll-pitch-yaw [rad] about fixed x, then y, then z: R = Rz(yaw) Ry(pitch) Rx(roll). The scenario file's convention.
inline glm::dquat QuaternionFromRollPitchYaw(const glm::dvec3& rpy) {
  return glm::angleAxis(rpy.z, glm::dvec3(0, 0, 1)) * glm::angleAxis(rpy.y, glm::dvec3(0, 1, 0)) *
         glm::angleAxis(rpy.x, glm::dvec3(1, 0, 0));
}

}  // namespace core
