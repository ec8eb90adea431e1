#pragma once

#include "vps/walk/walk_kernel.hpp"

namespace vps {

// *room: lower bound of the distance between S's points and G [voxels], the better the longer it looks: of the spheres
// that it knows, the one with the least bound gives way to its sixteen children, at most so many times. Returns how
// many spheres it has tested.
constexpr std::uint32_t kMostLooks = 8;
std::uint32_t FindRoom(const WalkInput& in, const WalkKernels& kernels, double* room);

}  // namespace vps
