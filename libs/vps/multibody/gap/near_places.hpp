#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "vps/sampling/touch_points.hpp"
#include "vps/walk/field_walk.hpp"

namespace vps {

// The places of S that a walk has found near G.
struct NearPlaces {
  const TouchPoints& S;
  const FieldWalkScratch& walk;
  const FieldWalkResult& result;
  float margin;  // voxels

  // take(group, near): the groups of a near block.
  template <class Take>
  void ForEachGroup(std::uint32_t near, const Take& take) const {
    const std::uint32_t block = walk.near_blocks[near];
    for (std::uint32_t g = S.group_begin[block]; g < S.group_begin[block + 1]; ++g) take(S.groups[g], near);
  }
  // take(point, depth): the near places of a group.
  template <class Take>
  void ForEachNear(std::uint16_t lanes, std::uint32_t near, const Take& take) const {
    const std::uint32_t first = walk.near_blocks[near] * kBlock;
    const float* const depths = walk.depths(near);
    for (unsigned rest = lanes; rest != 0; rest &= rest - 1) {
      const auto k = static_cast<std::uint32_t>(__builtin_ctz(rest));
      if (depths[k] >= -margin) take(first + k, depths[k]);
    }
  }
  // Minus infinity: not near.
  [[nodiscard]] float DepthOf(std::uint32_t point) const {
    const auto begin = walk.near_blocks.begin();
    const auto end = begin + result.num_near_blocks;
    const auto at = std::lower_bound(begin, end, point / kBlock);
    if (at == end || *at != point / kBlock) return -std::numeric_limits<float>::infinity();
    return walk.depths(static_cast<std::uint32_t>(at - begin))[point % kBlock];
  }
};

}  // namespace vps
