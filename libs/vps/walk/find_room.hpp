#pragma once

#include "vps/walk/walk_kernel.hpp"

namespace vps {

// *room: lower bound of the distance between S's points and G [voxels], the better the longer it looks: of the spheres
// that it knows, the two with the least bounds give way to their sixteen children each, until so many have. Returns how
// many spheres it has tested.
constexpr std::uint32_t kMostLooks = 6;
std::uint32_t FindRoom(const WalkInput& in, const WalkKernels& kernels, double* room);

}  // namespace vps
