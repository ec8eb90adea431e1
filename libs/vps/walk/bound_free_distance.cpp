#include "vps/walk/bound_free_distance.hpp"

#include <algorithm>
#include <limits>

namespace vps {

double BoundFreeDistance(const WalkInput& in, const WalkKernels& kernels, std::uint32_t* spheres_tested) {
  struct {
    std::uint32_t level, number;
  } blocks[kMostSphereBlocks];
  float bounds[kMostSphereBlocks][kBlock];
  float leasts[kMostSphereBlocks];  // of each block, since a search through all bounds takes longer than finding them
  std::uint32_t nearest = 0;        // block
  for (std::uint32_t n = 0; n < kMostSphereBlocks; ++n) {
    if (n == 0) {
      blocks[n] = {in.num_levels - 1, 0};
    } else {
      const auto& parent = blocks[nearest];
      if (parent.level == 0) break;
      float* const lane = std::find(bounds[nearest], bounds[nearest] + kBlock, leasts[nearest]);
      const auto k = static_cast<std::uint32_t>(lane - bounds[nearest]);
      blocks[n] = {parent.level - 1, parent.number * kBlock + k};
      *lane = std::numeric_limits<float>::infinity();
      leasts[nearest] = *std::min_element(bounds[nearest], bounds[nearest] + kBlock);
    }
    leasts[n] = kernels.bound(in, in.level_begin[blocks[n].level] + blocks[n].number, bounds[n]);
    *spheres_tested += kBlock;
    nearest = static_cast<std::uint32_t>(std::min_element(leasts, leasts + n + 1) - leasts);
  }
  return static_cast<double>(leasts[nearest]);
}

}  // namespace vps
