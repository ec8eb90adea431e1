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

// Reduces any number of contact points of a pair to at most core::kMaxContactPlanes planes with the same force, the
// same torque (but for moments about the mean normals) and the same stiffness against tilting.
//
// Points are put into up to four groups of similar normals. The penetrating points of a group become four or five
// planes along the direction of their summed force. They lie at nodes whose weights have the same sum, mean and
// variances as the points' stiffness, within the points' extent. With sigma^2 the variance along an axis and
// lo < 0 < hi the ends of the points, both from the mean, sigma^2 <= -lo hi (Bhatia and Davis 2000); so the weights of
// both rules are >= 0:
//   cross:   nodes lo and hi on each axis, with the weights sigma^2 / (-lo (hi - lo)) and sigma^2 / (hi (hi - lo)),
//            and the mean with the remaining weight;
//   square:  two nodes -sigma q, sigma / q on each axis, q = sqrt(-lo / hi); used where the cross would leave the mean
//            a negative weight.
// Node depths are a line in both directions, fitted to the points' force and torque, which are then exact. Where that
// line would make a node pull, nodes are placed by the points' forces in place of their stiffness, all at the mean
// depth. A group without penetrating points becomes planes in the same way, none farther off than its nearest point.
//
// Ids follow direction and node. Takes a few passes over the points for each group and does not allocate.
void ReduceContactPoints(std::span<const ContactPoint> points, const core::Pose& X_WS, const core::Pose& X_WG,
                         core::FixedVector<core::ContactPlane, core::kMaxContactPlanes>* planes);

}  // namespace physics
