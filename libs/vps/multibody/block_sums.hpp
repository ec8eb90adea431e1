#pragma once

#include <cstdint>
#include <limits>

#include "vps/field/four_lanes.hpp"
#include "vps/force/direction_bins.hpp"
#include "vps/force/reduce_patches.hpp"
#include "vps/sampling/point_block.hpp"

namespace vps {

using I4 = std::int32_t __attribute__((vector_size(16)));

inline float SumOfLanes(const F4& lanes) {
  return (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
}

// The penalty integral over the points of blocks (depths d in voxels, areas A as quadrature weights, positive parts):
//   volume = sum A d,  square = sum A d^2,  force = sum A d n,  moment = sum p x A d n.
class BlockSums {
 public:
  void Add(const PointBlock& block, const float* depths, float voxel_m) {
    for (std::uint32_t k = 0; k < kBlock; k += 4) {
      const F4 d = Load4(depths + k);
      const F4 depth_m = (d > 0.0f ? d : F4{}) * voxel_m;
      const F4 volume = Load4(block.area_m2 + k) * depth_m;  // places without a point have no area
      const F4 p[3] = {Load4(block.x + k), Load4(block.y + k), Load4(block.z + k)};
      const F4 f[3] = {volume * Load4(block.nx + k), volume * Load4(block.ny + k), volume * Load4(block.nz + k)};
      for (int i = 0; i < 3; ++i) {
        force_[i] += f[i];
        moment_[i] += p[(i + 1) % 3] * f[(i + 2) % 3] - p[(i + 2) % 3] * f[(i + 1) % 3];
      }
      volume_ += volume;
      square_ += volume * depth_m;
    }
  }
  void AddTo(ContactPatch* patch) const {
    for (int i = 0; i < 3; ++i) {
      patch->force_m3[i] += SumOfLanes(force_[i]);
      patch->moment_m4[i] += SumOfLanes(moment_[i]);
    }
    patch->volume_m3 += SumOfLanes(volume_);
    patch->square_m4 += SumOfLanes(square_);
  }

 private:
  F4 force_[3] = {};
  F4 moment_[3] = {};
  F4 volume_{};
  F4 square_{};
};

inline std::uint32_t FindDeepest(const float* depths) {
  F4 deepest = Load4(depths);
  I4 at = {0, 1, 2, 3};
  for (std::int32_t k = 4; k < static_cast<std::int32_t>(kBlock); k += 4) {
    const F4 d = Load4(depths + k);
    const I4 lanes = {k, k + 1, k + 2, k + 3};
    at = d > deepest ? lanes : at;
    deepest = d > deepest ? d : deepest;
  }
  // Without branches: they would be mispredicted.
  const auto take = [&](const F4& other, const I4& other_at) {
    at = other > deepest ? other_at : at;
    deepest = other > deepest ? other : deepest;
  };
  take(__builtin_shufflevector(deepest, deepest, 2, 3, 2, 3), __builtin_shufflevector(at, at, 2, 3, 2, 3));
  take(__builtin_shufflevector(deepest, deepest, 1, 1, 1, 1), __builtin_shufflevector(at, at, 1, 1, 1, 1));
  return static_cast<std::uint32_t>(at[0]);
}

inline glm::vec3 PointOf(const PointBlock& block, std::uint32_t k) {
  return {block.x[k], block.y[k], block.z[k]};
}

inline glm::vec3 NormalOf(const PointBlock& block, std::uint32_t k) {
  return {block.nx[k], block.ny[k], block.nz[k]};
}

// The depths of a block's points that face as n does, and of those that face elsewhere: more than 67.5 degrees off, so
// that two faces at a right angle are apart. -infinity for the points that are of the other kind.
struct FacingDepths {
  FacingDepths(const PointBlock& block, const float* depths, const glm::vec3& n) {
    constexpr F4 kNone = F4{} - std::numeric_limits<float>::infinity();
    I4 any = {};
    for (std::uint32_t k = 0; k < kBlock; k += 4) {
      const F4 along = Load4(block.nx + k) * n.x + Load4(block.ny + k) * n.y + Load4(block.nz + k) * n.z;
      const I4 is_elsewhere = along < kAcross;
      const F4 d = Load4(depths + k);
      Store4(is_elsewhere ? kNone : d, alike + k);
      Store4(is_elsewhere ? d : kNone, elsewhere + k);
      any |= is_elsewhere;
    }
    has_elsewhere = (any[0] | any[1] | any[2] | any[3]) != 0;
  }
  float alike[kBlock], elsewhere[kBlock];
  bool has_elsewhere;
};

// Of one point of a block.
inline void SetSums(const PointBlock& block, std::uint32_t k, float depth_m, ContactPatch* patch) {
  const float volume = depth_m > 0.0f ? block.area_m2[k] * depth_m : 0.0f;
  patch->force_m3 = volume * NormalOf(block, k);
  patch->moment_m4 = glm::cross(PointOf(block, k), patch->force_m3);
  patch->volume_m3 = volume;
  patch->square_m4 = volume * depth_m;
}

}  // namespace vps
