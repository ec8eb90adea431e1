#include "vps/walk/evaluate_points.hpp"

#include <array>

#include "vps/walk/walk_input.hpp"

namespace vps {
namespace {

constexpr std::uint32_t kOneLevel[1] = {0};

}  // namespace

void FindDepths(const PointBlock* points, const SphereBlock* spheres, std::uint32_t num_blocks,
                const DistanceField& field, const core::Pose& X_GS, BlockDepths* depths) {
  WalkInput in = MakeFieldInput(field, X_GS);
  in.points = points;
  in.spheres = spheres;
  KernelsOf(BestInstructionSet()).find_depths(in, num_blocks, reinterpret_cast<float(*)[kBlock]>(depths));
}

SphereSieve::SphereSieve(const DistanceField& field, const core::Pose& X_GS)
    : kernels_(KernelsOf(BestInstructionSet())), in_(MakeFieldInput(field, X_GS)) {
  in_.level_begin = kOneLevel;
  in_.num_levels = 1;
}

unsigned SphereSieve::MayBeInside(const SphereBlock& block) {
  std::array<std::uint32_t, 4 * kBlock> queue;
  in_.spheres = &block;
  WalkCull cull{};
  cull.queue = queue.data();
  cull.queue_half = 2 * kBlock;
  cull.most_spheres = 0xffffffffU;
  kernels_.cull(in_, &cull);
  unsigned lanes = 0;
  for (std::uint32_t i = 0; i < cull.num_blocks; ++i) lanes |= 1U << cull.blocks[i];
  return lanes;
}

void ComputeExactDepths(const DistanceField& field, const core::Pose& X_GS, InstructionSet set,
                        std::span<FacetPoints> points, FacetScratch* scratch) {
  if (field.facets.blocks.empty()) return;
  KernelsOf(set).measure(MakeFieldInput(field, X_GS), points.data(), static_cast<std::uint32_t>(points.size()),
                         scratch);
}

}  // namespace vps
