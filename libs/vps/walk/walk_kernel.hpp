#pragma once

#include <cstdint>

#include "vps/field/distance_field.hpp"
#include "vps/sampling/sample_tree.hpp"

namespace vps {

// Input of the kernels: plain pointers and numbers. The kernels are compiled once per instruction set; they must not
// use inline functions or templates that other files use too, or the linker could put their code into a program that
// runs on an older processor.
struct WalkInput {
  // Field.
  const std::uint32_t* bricks;
  const std::uint32_t* words;
  const std::uint32_t* creases;
  const CoarseCell* coarse;
  const std::uint32_t* curvatures;  // two in a word
  const FacetBlock* facet_blocks;
  const FacetSpheres* facet_spheres;
  const std::uint32_t* facet_level_begin;
  std::uint32_t num_facet_levels;
  std::int32_t nx, ny, nz, coarse_shift;
  // Tree.
  const PointBlock* points;
  const SphereBlock* spheres;
  const std::uint32_t* level_begin;
  std::uint32_t num_levels;
  // p_voxels = m p_S + t.
  float m[3][3];
  float t[3];
  float voxels_per_m, m_per_voxel;
  float margin;  // voxels: points nearer than this are reported
};

// Reconstruction error, voxels, that bounds by the distance at a cell's centre allow for: the fitted planes of a crease
// are off by up to 0.3 (decision 6), a curved cell by a few hundredths; the rest is margin.
constexpr float kCullSlack = 0.5f;
// Plane and distance agree at a cell's centre, each changes by at most the distance from it, half a diagonal: they
// differ by at most sqrt(3). Points in no cell of the band are farther than its 3 voxels less half a diagonal, 0.87.
constexpr float kModelSlack = 1.7321f;
constexpr float kBeyondBand = 2.1f;

// Spheres level by level; the queue of one level fills that of the next.
struct WalkCull {
  std::uint32_t* queue;  // twice `queue_half` entries, each half as many as point blocks
  std::uint32_t queue_half;
  // Not null: an estimate of the least distance of the points of each of the resulting blocks, in their order, voxels;
  // room for every block.
  float* estimates;
  // Results: the point blocks that may come near, ascending, within the queue.
  const std::uint32_t* blocks;
  std::uint32_t num_blocks;
  std::uint32_t spheres_tested;
  float free_distance;  // lower bound of the distance of everything that was culled, voxels
};

// Some point blocks, ascending, to be tested. Sums are of sixteen lanes, whatever the width of the registers, so that
// every instruction set adds in the same order.
struct alignas(64) WalkChunk {
  const std::uint32_t* blocks;
  std::uint32_t num_blocks;
  // Results: the near ones of the blocks, and their mean depths, voxels, positive inside; room for all of them.
  std::uint32_t* near_blocks;
  float (*near_depths)[kBlock];
  std::uint32_t num_near_blocks;
  std::uint32_t num_near, num_colliding;  // points
  float free_distance;                    // least distance of the points, voxels
  enum Sum { kFx, kFy, kFz, kMx, kMy, kMz, kVolume, kSquare, kMissed, kMissedSquared, kNumSums };
  // voxels * m^2, voxels * m^3, voxels * m^2, voxels^2 * m^2, voxels * m^2, voxels^2 * m^4
  alignas(64) float sums[kNumSums][kBlock];
  float depth[kBlock];  // deepest of each lane, voxels
  std::uint32_t depth_block[kBlock];
};

// Points whose exact depths are wanted, and their depths by the field; neighbours share a block. Those behind the last
// repeat it.
struct alignas(64) FacetPoints {
  float x[kBlock], y[kBlock], z[kBlock];     // S, m
  float depth[kBlock];                       // voxels, positive inside
  float gx[kBlock], gy[kBlock], gz[kBlock];  // result: gradient of the distance, in G; 0 where the depth was kept
};
// Largest error of the field, voxels (0.3 at true edges, decision 6): triangles farther from a point than its distance
// by the field plus this are not tested. First the usual error is tried, not derived: the p95 is 0.03.
constexpr float kMostFieldError = 0.5f;
constexpr float kUsualFieldError = 0.1f;
constexpr float kUnmet = -1.0f;  // of a squared distance: no triangle yet
// Near sixteen points; where there are more the field's depth is kept. Not derived: bounds the time of one exact depth.
constexpr std::uint32_t kMostFacetBlocks = 128;
constexpr std::uint32_t kFacetSlots = 32;  // unpacked blocks kept, 1.3 KB each; not derived
constexpr float kDoubt = 1e12f;            // voxels^2; taken off the squared distance

// The triangles of a block in frames of their own.
struct alignas(64) FacetFrames {
  float ax[kFacetLanes], ay[kFacetLanes], az[kFacetLanes];  // corner A
  float ux[kFacetLanes], uy[kFacetLanes], uz[kFacetLanes];  // towards B
  float vx[kFacetLanes], vy[kFacetLanes], vz[kFacetLanes];  // in the plane, towards C
  float nx[kFacetLanes], ny[kFacetLanes], nz[kFacetLanes];  // out of the solid
  float b[kFacetLanes], cx[kFacetLanes], cy[kFacetLanes];   // B is at (b, 0), C at (cx, cy)
  float inverse_bc[kFacetLanes], inverse_ca[kFacetLanes];   // one over the squared sides
  float yields[kFacetLanes];                                // of slivers: how much farther they count
  float mx[kFacetLanes], my[kFacetLanes], half_x[kFacetLanes];
  float doubt[kFacetLanes];  // kDoubt of a doubtful one, else 0
};
// Blocks of facets that come as near to c as `reach`, voxels, with their spheres; behind the last none.
struct NearFacets {
  alignas(64) std::uint32_t block[kMostFacetBlocks + 2 * kFacetLanes];
  FacetSpheres spheres[kMostFacetBlocks / kFacetLanes];
  std::uint32_t count;
  float c[3];
  float reach;
};
// Blocks unpacked last, each in the slot of its number's last bits.
struct FacetScratch {
  NearFacets near;
  FacetFrames frames[kFacetSlots];
  std::uint32_t block[kFacetSlots];
};

struct PatchBlock;
struct PatchInput;
struct PatchSums;

struct WalkKernels {
  void (*cull)(const WalkInput&, WalkCull*);
  void (*evaluate)(const WalkInput&, WalkChunk*);
  // Of the sixteen spheres of a block, counted from level 0's, lower bounds of the distance of what they hold, voxels.
  // Infinite of fillers, which have no children. Returns the least.
  float (*bound)(const WalkInput&, std::uint32_t block, float* bounds);
  void (*measure)(const WalkInput&, FacetPoints*, std::uint32_t count, FacetScratch*);
  // Depth and slope at the centres of sixteen patches; then their integrals, errors, and what is to be opened.
  void (*read)(const PatchInput&, PatchBlock*);
  void (*judge)(const PatchInput&, PatchBlock*, PatchSums*);
};
WalkKernels PortableWalkKernels();
#if defined(__x86_64__)
WalkKernels Avx2WalkKernels();
WalkKernels Avx512WalkKernels();
#endif

}  // namespace vps
