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
  std::uint32_t partial_block;  // the point block with fillers, or none
  // p_voxels = m p_S + t.
  float m[3][3];
  float t[3];
  float voxels_per_m;
  float margin;  // voxels: points nearer than this are reported
};

// What one chunk of blocks adds up to: sixteen lanes of everything that is summed, whatever the width of the registers,
// so that every instruction set adds in the same order.
struct alignas(64) WalkSums {
  enum Sum { kFx, kFy, kFz, kMx, kMy, kMz, kVolume, kSquare, kNumSums };
  double of[kNumSums][kBlock];  // voxels * m^2, voxels * m^3, voxels * m^2, voxels^2 * m^2
  float depth[kBlock];          // deepest of each lane, voxels
  std::uint32_t depth_block[kBlock];
  float room;  // lower bound of the distance of the points tested, voxels
  std::uint32_t num_near, num_colliding, num_near_blocks;
};

// Spheres survive when a point in them can be within the margin, with this to spare: the fitted planes of a crease may
// be off by 0.3 voxel, a curved cell by a few hundredths.
constexpr float kCullSlack = 0.5f;
// A plane model differs from the distance by no more than the distance of two points of the cell, twice: sqrt(3).
constexpr float kModelSlack = 1.7321f;

// What a window of 2 x 2 x 2 bricks takes off each brick's first word, so that adding the cell's x + 8 y + 64 z within
// the window, read with the bits of the float 1.5 * 2^23 below, leads to the word: 8 x + 64 y + 512 z of the brick.
constexpr std::uint32_t kTaken[8] = {0x4b400000U + 0,   0x4b400000U + 8,   0x4b400000U + 64,  0x4b400000U + 72,
                                     0x4b400000U + 512, 0x4b400000U + 520, 0x4b400000U + 576, 0x4b400000U + 584};

// Spheres level by level; the queue of one level fills that of the next.
struct WalkCull {
  std::uint32_t* queue;  // twice `queue_half` entries, each half as many as point blocks
  std::uint32_t queue_half;
  // Results: the point blocks that may come near, ascending, within the queue.
  const std::uint32_t* blocks;
  std::uint32_t num_blocks;
  std::uint32_t spheres_tested;
  float room;  // lower bound of the distance of everything that was culled, voxels
};

// Blocks of one chunk, ascending. near_blocks and near_depths have room for all of them.
struct WalkChunk {
  const std::uint32_t* blocks;
  std::uint32_t num_blocks;
  std::uint32_t* near_blocks;
  float (*near_depths)[kBlock];  // voxels, positive inside
};

struct WalkKernels {
  void (*cull)(const WalkInput&, WalkCull*);
  void (*evaluate)(const WalkInput&, const WalkChunk&, WalkSums*);
};
WalkKernels PortableWalkKernels();
#if defined(__x86_64__)
WalkKernels Avx2WalkKernels();
WalkKernels Avx512WalkKernels();
#endif

}  // namespace vps
