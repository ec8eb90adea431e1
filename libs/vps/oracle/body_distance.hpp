#pragma once

#include "core/pose.hpp"
#include "vps/oracle/mesh_distance.hpp"

namespace vps::oracle {

// Signed distance of two bodies [m]. Apart: the least distance of their surfaces. Else negative: the greater of the
// deepest penetration of B's surface in A and of A's surface in B, where a point's penetration is its distance to the
// other surface. (Not the shortest translation that separates them, which is never less.)
struct BodyDistance {
  double signed_distance_m = 0.0;
  glm::dvec3 p_A_m{0.0};        // the deepest point, or the nearest one of B's surface, in A's frame
  double error_bound_m = 0.0;   // the true depth is at most this much deeper; 0 when apart
  bool is_deepest_in_A = true;  // the deepest point belongs to B's surface
};

BodyDistance SignedBodyDistance(const MeshDistance& A, const MeshDistance& B, const core::Pose& X_AB);

struct Deepest {
  double depth_m = 0.0;  // 0: no point of B's surface is inside A
  glm::dvec3 p_A_m{0.0};
  double error_bound_m = 0.0;
};
// Deepest point of B's surface in A by branch and bound, to 1e-3 of the depth or 1e-9 of B's size.
Deepest FindDeepest(const MeshDistance& A, const MeshDistance& B, const core::Pose& X_AB);

// Least distance of the two surfaces, exact to rounding; 0 where they meet.
double SurfaceDistance(const MeshDistance& A, const MeshDistance& B, const core::Pose& X_AB,
                       glm::dvec3* p_A_m = nullptr);

}  // namespace vps::oracle
