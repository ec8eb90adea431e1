#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "core/pose.hpp"

namespace visual_node {

// Homogeneous matrix [R_AB p_AB; 0 1] of a pose, computed in double and converted to float for OpenGL.
inline glm::mat4 ToMatrix(const core::Pose& X_AB) {
  glm::dmat4 matrix = glm::mat4_cast(X_AB.rotation);
  matrix[3] = glm::dvec4(X_AB.translation, 1.0);
  return glm::mat4(matrix);
}

// Whether a sphere lies beyond one side of the picture. A point p is within all of them when |x| and |y| of clip_W p
// are at most its w.
inline bool IsOutside(const glm::mat4& clip_W, const glm::vec3& centre_W, float radius_m) {
  const glm::mat4 rows = glm::transpose(clip_W);
  for (const glm::vec4& side : {rows[3] + rows[0], rows[3] - rows[0], rows[3] + rows[1], rows[3] - rows[1]}) {
    if (glm::dot(side, glm::vec4(centre_W, 1.0f)) < -radius_m * glm::length(glm::vec3(side))) return true;
  }
  return false;
}

}  // namespace visual_node
