#include "vps/walk/bound_free_distance.hpp"

#include <algorithm>
#include <limits>

namespace vps {

double BoundFreeDistance(const WalkInput& in, const WalkKernels& kernels, std::uint32_t* spheres_tested) {
  struct {
    std::uint32_t level, number;
  } blocks[kMostSphereBlocks];
  float bounds[kMostSphereBlocks * kBlock];
  std::uint32_t least = 0;
  for (std::uint32_t n = 0; n < kMostSphereBlocks; ++n) {
    if (n == 0) {
      blocks[n] = {in.num_levels - 1, 0};
    } else {
      const auto& parent = blocks[least / kBlock];
      if (parent.level == 0) break;
      blocks[n] = {parent.level - 1, parent.number * kBlock + least % kBlock};
      bounds[least] = std::numeric_limits<float>::infinity();
    }
    kernels.bound(in, in.level_begin[blocks[n].level] + blocks[n].number, bounds + n * kBlock);
    *spheres_tested += kBlock;
    least = static_cast<std::uint32_t>(std::min_element(bounds, bounds + (n + 1) * kBlock) - bounds);
  }
  return static_cast<double>(bounds[least]);
}

}  // namespace vps
