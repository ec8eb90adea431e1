#include "vps/walk/walk_memory.hpp"

#include <algorithm>

namespace vps {

double MotionBound(const core::Pose& X_GS_before, const glm::dvec3& centre_G_before, const core::Pose& X_GS_now,
                   const glm::dvec3& centre_S, double radius_m) {
  const glm::dquat turn = glm::conjugate(X_GS_before.rotation) * X_GS_now.rotation;
  return glm::length(X_GS_now * centre_S - centre_G_before) +
         2.0 * glm::length(glm::dvec3(turn.x, turn.y, turn.z)) * radius_m;
}

double FieldWalkMemory::RemainingFreeDistance_m(const SampleTree& S, const DistanceField& G, const core::Pose& X_GS_now,
                                                double margin_now_m) const {
  // Error of a point's place in the walk's floats, voxels: twice BoundCells' allowance, at two poses.
  constexpr double kRounding = 4e-3;
  if (sampled != &S || field != &G || margin_m != margin_now_m || !(free_m > 0.0)) return 0.0;
  const double moved_m = MotionBound(X_GS, centre_G, X_GS_now, S.centre_m, S.radius_m) + kRounding * G.voxel_size_m;
  return std::max(0.0, free_m - moved_m);
}

}  // namespace vps
