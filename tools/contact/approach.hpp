#pragma once

#include <vector>

#include "core/pose.hpp"
#include "tools/contact/workload.hpp"
#include "vps/testing/case_random.hpp"
#include "vps/tree/point_tree.hpp"
#include "vps/voxmap/voxmap.hpp"

namespace contact {

// `count` poses X_AB. B, at a random attitude, moves from a random side towards A's middle, and stops at a random depth
// within the bounds past the first touch (negative: before it).
std::vector<core::Pose> Approach(const Parts& parts, double least_depth_m, double greatest_depth_m, int count,
                                 vps::CaseRandom* random);

// A hand's motions of B (SmoothWalk), one from each start, that keep B's deepest point within the two depths (negative:
// apart). The depth is that of the layers of `paper`, in voxels of 1/200 of A's longest side: neither `fast` nor the
// exact answers choose the poses at which they are compared. A band that begins beyond 10 mm apart is not kept.
// `step_m`: mean length of a step of a point of B's surface.
std::vector<std::vector<core::Pose>> WanderInBand(const Parts& parts, const std::vector<core::Pose>& starts,
                                                  double step_m, double least_depth_m, double greatest_depth_m,
                                                  int steps, vps::CaseRandom* random);

}  // namespace contact
