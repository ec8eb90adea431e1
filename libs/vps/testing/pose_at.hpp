#pragma once

#include "core/pose.hpp"

namespace vps {

// At (x, y, z) [m], turned by the rotation vector `turn` [rad].
inline core::Pose At(double x, double y, double z, const glm::dvec3& turn = glm::dvec3(0.0)) {
  return {core::QuaternionFromRotationVector(turn), {x, y, z}};
}

}  // namespace vps
