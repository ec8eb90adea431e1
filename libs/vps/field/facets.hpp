#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace vps {

constexpr std::uint32_t kFacetLanes = 16;  // triangles of a block, corners of a block, spheres of a block
// Voxels; rounding is half of it along each axis. Places up to 256 voxels from the grid's origin are exact in floats,
// so that a corner shared by two blocks is the same place in both: more than 24 bits would not be.
constexpr float kFacetStep = 1.0f / 65536.0f;
constexpr std::int32_t kMostFacetSteps = 64 * 65536 - 1;  // a corner's along each axis; not derived: 64 voxels
// Places nearer than this are the same to the gaps of a tool, voxels. Not derived: a micrometre at voxels of 0.5 mm.
constexpr double kSamePlace = 1.0 / 512.0;

// The side of the triangle on which a point lies does not determine whether it is inside.
constexpr std::uint16_t kDoubtful = 1U << 12;

// Up to sixteen neighbouring triangles that share up to sixteen corners. Corners are relative to the middle of the
// block's sphere in steps of kFacetStep; the middle is a whole number of steps itself, so that a corner shared by two
// blocks is the same place in both.
struct alignas(64) FacetBlock {
  std::int32_t x[kFacetLanes], y[kFacetLanes], z[kFacetLanes];
  // Of each triangle three numbers of four bits, and kDoubtful; the last triangle is repeated.
  std::uint16_t corners[kFacetLanes];
};
static_assert(sizeof(FacetBlock) == 256);

struct alignas(64) FacetSpheres {
  float x[kFacetLanes], y[kFacetLanes], z[kFacetLanes], r[kFacetLanes];  // voxels
};

// Boxes around what the spheres of a block stand for. The spheres of long thin triangles are wide, the boxes of those
// along an axis are not. Of unused ones the lower corner is far away.
struct alignas(64) FacetBoxes {
  float low[3][kFacetLanes], high[3][kFacetLanes];  // voxels
};

// The surface's triangles for exact distances at a few points, packed: about twenty bytes a triangle. In voxels of the
// field. Sphere j of level 0 holds block j, sphere j of level k the spheres of block j of level k - 1; the last level
// is one block. Unused spheres are far away and have no radius.
struct Facets {
  static constexpr std::uint32_t kMaxLevels = 6;
  static constexpr float kFarAway = 1e9f;

  std::vector<FacetBlock> blocks;
  std::vector<FacetSpheres> spheres;
  std::vector<FacetBoxes> boxes;  // in the order of `spheres`; MakeBoxes
  std::array<std::uint32_t, kMaxLevels> level_begin{};
  std::uint32_t num_levels = 0;

  // As kept in files, without the boxes.
  [[nodiscard]] std::size_t num_bytes() const {
    return sizeof(FacetBlock) * blocks.size() + sizeof(FacetSpheres) * spheres.size();
  }
};

}  // namespace vps
