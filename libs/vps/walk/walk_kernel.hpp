#pragma once

#include <cstdint>

#include "vps/field/distance_field.hpp"
#include "vps/sampling/sample_tree.hpp"

namespace vps {

// What the kernels see: plain pointers and numbers. The kernels are compiled once per instruction set; they must not
// use inline functions or templates that other files use too, or the linker could put their code into a program that
// runs on an older processor.
struct WalkInput {
  // Field.
  const std::uint32_t* bricks;
  const std::uint32_t* words;
  const std::uint32_t* creases;
  const CoarseCell* coarse;
  std::int32_t nx, ny, nz, coarse_shift;
  // Tree.
  const PointBlock* points;
  const SphereBlock* spheres;
  const std::uint32_t* level_begin;
  std::uint32_t num_levels;
  // p_voxels = m p_S + t.
  float m[3][3];
  float t[3];
  float voxels_per_m;
  float margin;  // voxels: points nearer than this are reported
};

// Sixteen lanes of everything that is summed, whatever the width of the registers, so that every instruction set adds
// the same numbers in the same order.
struct WalkOutput {
  enum Sum { kFx, kFy, kFz, kMx, kMy, kMz, kVolume, kSquare, kNumSums };
  double sums[kNumSums][kBlock];  // voxels * m^2, voxels * m^3, voxels * m^2, voxels^2 * m^2
  float depth[kBlock];            // deepest of each lane, voxels
  std::uint32_t depth_block[kBlock];
  float room;  // how far every point of S may move before one can come within the margin, voxels; valid without hits
  std::uint32_t num_near, num_colliding, num_near_blocks, spheres_tested, points_tested;
};

// Spheres survive when a point in them can be within the margin, with this to spare: the fitted planes of a crease may
// be off by 0.3 voxel, a curved cell by a few hundredths.
constexpr float kCullSlack = 0.5f;
// A plane model differs from the distance by no more than the distance of two points of the cell, twice: sqrt(3).
constexpr float kModelSlack = 1.7321f;

// Scratch: `queue` holds twice the number of point blocks; near_blocks and near_depths one entry per point block.
struct WalkScratch {
  std::uint32_t* queue;
  std::uint32_t queue_half;
  std::uint32_t* near_blocks;
  float (*near_depths)[kBlock];  // voxels, positive inside
};

using WalkKernel = void (*)(const WalkInput&, const WalkScratch&, WalkOutput*);
void WalkPortable(const WalkInput& input, const WalkScratch& scratch, WalkOutput* output);
#if defined(__x86_64__)
void WalkAvx2(const WalkInput& input, const WalkScratch& scratch, WalkOutput* output);
void WalkAvx512(const WalkInput& input, const WalkScratch& scratch, WalkOutput* output);
#endif

}  // namespace vps
