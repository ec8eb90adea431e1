#pragma once

#include <optional>

#include "core/pose.hpp"
#include "vps/mesh/triangle_mesh.hpp"
#include "vps/oracle/mesh_distance.hpp"

namespace vps::oracle {

// First contact of B, turned by `R_AB` and moving along -from_A (unit) from far away with the middle of its box aimed
// at the middle of A's box; by sphere tracing: a step of the distance cannot pass through. Beyond(depth_m) is the pose
// `depth_m` beyond the touch; negative: before it.
struct FirstTouch {
  core::Pose X_AB;
  glm::dvec3 from_A{0.0};
  [[nodiscard]] core::Pose Beyond(double depth_m) const { return {X_AB.rotation, X_AB.translation - depth_m * from_A}; }
};

// Nothing when B passes through a hole without a touch.
std::optional<FirstTouch> FindFirstTouch(const MeshDistance& A, const Box& box_A, const MeshDistance& B,
                                         const Box& box_B, const glm::dquat& R_AB, const glm::dvec3& from_A);

}  // namespace vps::oracle
