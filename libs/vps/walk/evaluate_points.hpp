#pragma once

#include <span>

#include "core/pose.hpp"
#include "vps/field/distance_field.hpp"
#include "vps/sampling/sample_tree.hpp"
#include "vps/walk/field_walk.hpp"
#include "vps/walk/walk_kernel.hpp"

namespace vps {

// Depths, in voxels and positive inside, of blocks of points that no tree leads to, by the widest kernel. Sphere j
// holds block j's points (centre and radius count; sixteen to a SphereBlock). At most kMostBlocksAtOnce. Does not
// allocate.
struct alignas(64) BlockDepths {
  float of[kBlock];
};
constexpr std::uint32_t kMostBlocksAtOnce = 1024;
void FindDepths(const PointBlock* points, const SphereBlock* spheres, std::uint32_t num_blocks,
                const DistanceField& field, const core::Pose& X_GS, BlockDepths* depths);

// Tells of spheres which of them may hold a place inside: what a walk asks of the spheres of a tree. Slabs count.
class SphereSieve {
 public:
  SphereSieve(const DistanceField& field, const core::Pose& X_GS);
  // The lanes of a block that may, as bits.
  [[nodiscard]] unsigned MayBeInside(const SphereBlock& block);

 private:
  WalkKernels kernels_;
  WalkInput in_;
};

// Turns depths by the field at sixteen points each into exact ones, by the field's facets. `set`: the instructions to
// use. Does not allocate. Points near more facets than kMostFacetBlocks hold, and those whose depth is off by more than
// kMostFieldError, keep what they have.
void MeasureDepths(const DistanceField& field, const core::Pose& X_GS, InstructionSet set,
                   std::span<FacetPoints> points, FacetScratch* scratch);

}  // namespace vps
