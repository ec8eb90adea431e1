#pragma once

#include "core/pose.hpp"
#include "vps/field/distance_field.hpp"
#include "vps/sampling/sample_tree.hpp"

namespace vps {

// Upper bound of how far any point of a ball of S has moved in G between two poses [m]; the ball's centre was at
// centre_G_before. A turn by the angle a moves a point at distance r from its axis by 2 sin(a / 2) r, and sin(a / 2) is
// the length of the relative quaternion's vector.
double MotionBound(const core::Pose& X_GS_before, const glm::dvec3& centre_G_before, const core::Pose& X_GS_now,
                   const glm::dvec3& centre_S, double radius_m);

// What one pair's last walk has proven: how far S may move before anything of it can come within the margin. It is
// compared with the motion since that walk's pose, so nothing drifts.
struct FieldWalkMemory {
  const SampleTree* sampled = nullptr;
  const DistanceField* field = nullptr;
  double margin_m = 0.0;
  core::Pose X_GS;
  glm::dvec3 centre_G{0.0};  // of S's ball at that pose
  double free_m = 0.0;       // 0: something was near

  // How much of it is left [m]; 0: unknown, a walk is needed. Quick, for the many calls in which nothing is near.
  [[nodiscard]] double RemainingFreeDistance_m(const SampleTree& S, const DistanceField& G, const core::Pose& X_GS_now,
                                               double margin_now_m) const;
};

}  // namespace vps
