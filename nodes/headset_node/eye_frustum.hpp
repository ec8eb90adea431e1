#pragma once

#include <openxr/openxr.h>

#include <cmath>

#include "core/pose.hpp"
#include "view/frustum.hpp"

namespace headset_node {

// OpenXR's frames have x to the right, y up, and look along -z. The room R (view/room.hpp) has x to the right, y ahead,
// z up: p_R = (x, -z, y).
inline glm::dvec3 ToRoom(const XrVector3f& p) {
  return {p.x, -p.z, p.y};
}

// What an eye of the headset sees. R's origin is that of the headset's own space: where it was when it was put on.
inline view::Frustum FrustumOf(const core::Pose& X_WR, const XrView& eye) {
  const XrQuaternionf& q = eye.pose.orientation;
  const glm::dmat3 R_XE = glm::mat3_cast(glm::dquat(q.w, q.x, q.y, q.z));  // X: OpenXR's frame
  glm::dmat3 R_RE;
  for (int k = 0; k < 3; ++k) R_RE[k] = {R_XE[k].x, -R_XE[k].z, R_XE[k].y};
  const auto edge = [](float angle_rad) { return std::tan(static_cast<double>(angle_rad)); };
  return {X_WR * ToRoom(eye.pose.position), glm::mat3_cast(X_WR.rotation) * R_RE,
          edge(eye.fov.angleLeft),          edge(eye.fov.angleRight),
          edge(eye.fov.angleDown),          edge(eye.fov.angleUp)};
}

}  // namespace headset_node
