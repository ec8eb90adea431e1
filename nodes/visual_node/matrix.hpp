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

}  // namespace visual_node
