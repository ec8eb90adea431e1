#pragma once

#include <glm/glm.hpp>
#include <span>

#include "core/fixed_vector.hpp"
#include "core/messages/haptic.hpp"
#include "core/pose.hpp"

namespace physics {

// One of many points at which S touches G or comes near it, at the present poses.
struct ContactPoint {
  glm::dvec3 p_W{0.0};
  glm::dvec3 n_W{0.0, 0.0, 1.0};  // unit, from G to S
  double gap_m = 0.0;             // along n_W, negative inside
  double stiffness_N_per_m = 0.0;
};

// Reduces any number of contact points of a pair to at most core::kMaxContactPlanes planes that push with the same
// force and, but for moments about the mean normals, the same torque, and resist tilting alike.
//
// Points are put into up to four groups of like normals. The points of a group that push become four or five planes
// along the direction of their sum of forces, at nodes whose weights have the same sum, mean and variances as the
// points' stiffness, and which do not reach beyond them: with sigma^2 the variance along an axis and lo < 0 < hi the
// points' ends, both from the mean, sigma^2 <= -lo hi (Bhatia and Davis 2000), so that each rule below has weights >=
// 0.
//   cross:  nodes lo, hi on each axis and the mean; weights sigma^2 / (-lo (hi - lo)), sigma^2 / (hi (hi - lo)), the
//   rest square: two nodes -sigma q, sigma / q on each axis, q = sqrt(-lo / hi); where the cross would have no rest
// Their gaps are the line through the points' forces in both directions: force and torque are exact. Where that would
// make a node pull, nodes are made from the points' forces in place of their stiffness, all as deep as the mean. A
// group that only comes near becomes planes in the same way, none farther than its gaps tell.
//
// Ids follow direction and node. Takes two passes over the points for each group and does not allocate.
void ReduceContactPoints(std::span<const ContactPoint> points, const core::Pose& X_WS, const core::Pose& X_WG,
                         core::FixedVector<core::ContactPlane, core::kMaxContactPlanes>* planes);

}  // namespace physics
