#include "vps/walk/evaluate_points.hpp"

#include <array>
#include <cstring>
#include <numeric>

#include "vps/walk/field_walk.hpp"
#include "vps/walk/walk_kernel.hpp"

namespace vps {
namespace {

WalkKernels Kernels() {
#if defined(__x86_64__)
  if (BestInstructionSet() == InstructionSet::kAvx512) return Avx512WalkKernels();
  if (BestInstructionSet() == InstructionSet::kAvx2) return Avx2WalkKernels();
#endif
  return PortableWalkKernels();
}

constexpr float kEverything = 1e9f;  // voxels

}  // namespace

void FindDepths(const PointBlock* points, const SphereBlock* spheres, std::uint32_t num_blocks,
                const DistanceField& field, const core::Pose& X_GS, BlockDepths* depths) {
  const FieldTransform T(X_GS, field);
  WalkInput in{};
  in.bricks = field.bricks.data();
  in.words = field.words.data();
  in.creases = field.creases.data();
  in.coarse = field.coarse.data();
  in.nx = field.nx;
  in.ny = field.ny;
  in.nz = field.nz;
  in.coarse_shift = field.coarse_shift;
  in.points = points;
  in.spheres = spheres;
  in.partial_block = 0xffffffffU;
  std::memcpy(in.m, T.m, sizeof in.m);
  std::memcpy(in.t, T.t, sizeof in.t);
  in.voxels_per_m = static_cast<float>(1.0 / field.voxel_size_m);
  in.m_per_voxel = static_cast<float>(field.voxel_size_m);
  in.margin = kEverything;
  std::array<std::uint32_t, kMostBlocksAtOnce> blocks;
  std::array<std::uint32_t, kMostBlocksAtOnce> near;
  std::iota(blocks.begin(), blocks.begin() + num_blocks, 0U);
  WalkChunk chunk{};
  chunk.blocks = blocks.data();
  chunk.num_blocks = num_blocks;
  chunk.near_blocks = near.data();
  chunk.near_depths = reinterpret_cast<float(*)[kBlock]>(depths);
  WalkSums sums;
  Kernels().evaluate(in, chunk, &sums);
}

}  // namespace vps
