#pragma once

#include "vps/walk/walk_kernel.hpp"

namespace vps {

// *free_distance: lower bound of the distance between S's points and G [voxels], by best-first refinement: of the
// spheres known, the two with the least bounds are replaced by their sixteen children each, until more than
// kMostSphereBlocks blocks of spheres have been bounded. Returns the number of spheres tested. Not derived: more blocks
// give a better bound and take longer.
constexpr std::uint32_t kMostSphereBlocks = 6;
std::uint32_t BoundFreeDistance(const WalkInput& in, const WalkKernels& kernels, double* free_distance);

}  // namespace vps
