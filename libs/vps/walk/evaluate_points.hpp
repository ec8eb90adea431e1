#pragma once

#include <span>

#include "core/pose.hpp"
#include "vps/field/distance_field.hpp"
#include "vps/sampling/sample_tree.hpp"
#include "vps/walk/field_walk.hpp"
#include "vps/walk/walk_kernel.hpp"

namespace vps {

// Depths, in voxels and positive inside, of blocks of points without a tree, by the field and the widest kernel. Points
// in S's mesh frame, metres. Sphere j holds block j's points (only centre and radius are read; sixteen to a
// SphereBlock). At most kMostBlocksAtOnce. Does not allocate.
struct alignas(64) BlockDepths {
  float of[kBlock];
};
constexpr std::uint32_t kMostBlocksAtOnce = 1024;  // not derived; bounds the index lists on the stack to 8 KB
void FindDepths(const PointBlock* points, const SphereBlock* spheres, std::uint32_t num_blocks,
                const DistanceField& field, const core::Pose& X_GS, BlockDepths* depths);

// Culls spheres that hold no place inside, by the conservative bounds that a walk uses for the leaves of a tree, slabs
// included.
class SphereSieve {
 public:
  SphereSieve(const DistanceField& field, const core::Pose& X_GS);

  // Bit k: sphere k of the block may hold a place inside.
  [[nodiscard]] unsigned MayBeInside(const SphereBlock& block);

 private:
  WalkKernels kernels_;
  WalkInput in_;
};

// Replaces depths by the field, sixteen points at a time, by exact ones from the field's facets. `set`: the
// instructions to use. Does not allocate. Points near more facets than kMostFacetBlocks hold, and those whose depth is
// off by more than kMostFieldError, keep the field's depth.
void ComputeExactDepths(const DistanceField& field, const core::Pose& X_GS, InstructionSet set,
                        std::span<FacetPoints> points, FacetScratch* scratch);

}  // namespace vps
