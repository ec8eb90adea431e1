#pragma once

#include "vps/walk/walk_kernel.hpp"

namespace vps {

// Blocks of spheres that are bounded. Not derived: more of them give a better bound and take longer.
constexpr std::uint32_t kMostSphereBlocks = 7;

// Lower bound of the distance between S's points and G [voxels], by best-first refinement: of the spheres known, the
// one with the least bound is replaced by its sixteen children. Adds the number of spheres tested.
double BoundFreeDistance(const WalkInput& in, const WalkKernels& kernels, std::uint32_t* spheres_tested);

}  // namespace vps
