#pragma once

#include <vector>

#include "core/pose.hpp"
#include "tools/contact/random.hpp"
#include "tools/contact/workload.hpp"
#include "vps/tree/point_tree.hpp"
#include "vps/voxmap/voxmap.hpp"

namespace contact {

// Poses at which B, turned at random and pushed from a random side towards A's middle, has gone a depth between the two
// given beyond the first touch (negative: stopped before it).
std::vector<core::Pose> Approach(const Parts& parts, double least_depth_m, double greatest_depth_m, int count,
                                 Random* random);

// Hand's motions of B that begin at the given poses and keep the deepest point of B between two depths (negative:
// apart), as the layers of `paper` in voxels of a two hundredth of A's size see it: what all are compared with must not
// choose their poses. Farther apart than 10 mm nothing is kept. `step_m`: mean length of a step of a point of B's
// surface.
std::vector<std::vector<core::Pose>> WanderInBand(const Parts& parts, const std::vector<core::Pose>& starts,
                                                  double step_m, double least_depth_m, double greatest_depth_m,
                                                  int steps, Random* random);

}  // namespace contact
