#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "vps/field/facets.hpp"
#include "vps/field/field_word.hpp"

namespace vps {

// Exact distance and gradient at the centre of a coarse cell, in voxels, and two conservative bounds by BoundCells of
// how far the field lies below a plane ("fall"). With them walks cull points that face a surface closely without
// touching it. A bound is (code - 1) / kFallSteps voxels; code 0: not known.
// - Wide, in the distance's last eight bits (which changes it by less than 2^-15 of itself):
//     field(p) >= plane of the cell(p) - wide   at any point p of the cell grown by kWideMargin.
// - Close, in the gradient's bits 24-31:
//     field(p) >= plane of the voxel(p) - close   at any point p within kCloseRadius of a voxel of the cell that is a
//   plane with |distance| <= kMostAnchorDistance.
struct CoarseCell {
  float distance = 0.0f;
  std::uint32_t gradient = 0;  // EncodeCoarseGradient
};
constexpr float kFallSteps = 64.0f;    // codes reach 254 / 64 = 4 voxels, kWideMargin at a slope of 1
constexpr float kWideMargin = 4.0f;    // voxels; the edge of the smallest coarse cell, so that neighbours are enough
constexpr float kCloseRadius = 0.75f;  // voxels; not derived: below 1 for neighbours to be enough, holds a dense block
// Voxels: 1.25 + sqrt(3) < kBandVoxels, so that all neighbours of an anchor are in the band.
constexpr float kMostAnchorDistance = 1.25f;

// Step of DistanceField::curvatures, the sum of the principal curvatures [1/voxel], positive where the surface bulges:
// 16 bits reach +-4, a ball of half a voxel.
constexpr float kCurvatureStep = 1.0f / 8192.0f;

// Step of DistanceField::errors [voxels]: a quarter of the step of words; eight bits reach a quarter of a voxel.
constexpr float kErrorStep = 1.0f / 1024.0f;

// Signed distance to a closed surface (negative inside), made to be read by many points at once.
//
// Lengths are in voxels of a grid whose voxel (i,j,k) spans [i,i+1] x ... from `origin_m` in the mesh frame. Near the
// surface cells are voxels, kept in bricks of 8^3: a tangent plane each (field_word.hpp), or up to four where the
// distance has a crease. Everywhere else the coarse grid, cells of `1 << coarse_shift` voxels, holds the field, so that
// points deep inside get their depth and direction, and far spheres a bound for culling. Decisions 5, 6, 13.
struct DistanceField {
  static constexpr int kBrick = 8;
  static constexpr std::uint32_t kBrickWords = 512;
  // Half width of the narrow band: every sample nearer than this is in a brick. OpenVDB's default; more takes memory in
  // proportion, less leaves more of the depths to coarse cells (decision 13).
  static constexpr float kBandVoxels = 3.0f;
  // The grid's border around the mesh, the larger of the two: as Voxmap.
  static constexpr int kMinBorder = 8;
  static constexpr double kBorder_m = 2.5e-3;

  glm::dvec3 origin_m{0.0};
  double voxel_size_m = 0.0;
  std::int32_t nx = 0, ny = 0, nz = 0;  // voxels, multiples of the coarse cell and of 8
  std::int32_t coarse_shift = 2;
  std::vector<std::uint32_t> bricks;   // first word of each brick, x fastest; equal ones share, empty ones that at 0
  std::vector<std::uint32_t> words;    // [brick + WordInBrick(x, y, z)]
  std::vector<std::uint32_t> creases;  // kPlanesPerCrease each
  std::vector<CoarseCell> coarse;
  std::vector<std::int16_t> curvatures;  // of each brick, padded to a whole word: ComputeBrickTraits
  std::vector<std::uint8_t> errors;      // of each brick: ComputeBrickTraits
  Facets facets;                         // the surface itself, where it is not much more than the rest: PackFacets
  Facets surface;                        // the same for single places, where `facets` were not kept

  // Empty: none are stored.
  [[nodiscard]] const Facets& triangles() const { return facets.blocks.empty() ? surface : facets; }
  [[nodiscard]] std::size_t num_bytes() const {
    return 4 * (bricks.size() + words.size() + creases.size()) + sizeof(CoarseCell) * coarse.size() +
           2 * curvatures.size() + errors.size() + facets.num_bytes() + surface.num_bytes() +
           sizeof(FacetBoxes) * (facets.boxes.size() + surface.boxes.size());
  }
};

// Place of a voxel's word in its brick: tiles of 4 x 2 x 2 voxels are a cache line, so that points of a surface find
// each other's lines whichever way it faces. Of x, y, z the last three bits count.
constexpr std::uint32_t WordInBrick(std::int32_t x, std::int32_t y, std::int32_t z) {
  return static_cast<std::uint32_t>((x & 3) | (y & 1) << 2 | (z & 1) << 3 | (x >> 2 & 1) << 4 | (y >> 1 & 3) << 5 |
                                    (z >> 1 & 3) << 7);
}

// The field at a point.
struct FieldSample {
  float distance = 0.0f;         // voxels
  glm::vec3 gradient{0, 0, 1};   // about unit
  float cell = 1.0f;             // edge of the cell, voxels
  float centre_distance = 0.0f;  // exact distance at that cell's centre (plane cells and coarse cells), voxels
  float centre_offset = 0.0f;    // how far the point is from it, voxels
};

// The field at p [voxels]: d(c) + g . (p - c) of the cell with centre c, creases combined as field_word.hpp defines.
// Outside the grid the larger of the distance from the grid and the border cell's: the surface is farther than both.
// Reference for the kernels of walk/, which differ by rounding.
inline FieldSample SampleField(const DistanceField& field, const glm::vec3& p) {
  const glm::vec3 last(static_cast<float>(field.nx) - 0.5f, static_cast<float>(field.ny) - 0.5f,
                       static_cast<float>(field.nz) - 0.5f);
  const glm::vec3 q(std::min(std::max(p.x, 0.0f), last.x), std::min(std::max(p.y, 0.0f), last.y),
                    std::min(std::max(p.z, 0.0f), last.z));
  const glm::ivec3 c(q);
  const int bx = field.nx >> 3;
  const int by = field.ny >> 3;
  const std::uint32_t brick = field.bricks[static_cast<std::size_t>(((c.z >> 3) * by + (c.y >> 3)) * bx + (c.x >> 3))];
  const std::uint32_t word = field.words[brick + WordInBrick(c.x, c.y, c.z)];
  FieldSample sample;
  glm::vec3 e(q.x - static_cast<float>(c.x) - 0.5f, q.y - static_cast<float>(c.y) - 0.5f,
              q.z - static_cast<float>(c.z) - 0.5f);
  const CellKind kind = KindOf(word);
  const auto plane = [&](float d, const glm::vec3& g) { return d + ((g.x * e.x + g.y * e.y) + g.z * e.z); };
  if (kind == CellKind::kCoarse) {
    const int shift = field.coarse_shift;
    const glm::ivec3 cc(c.x >> shift, c.y >> shift, c.z >> shift);
    const CoarseCell& cell =
        field.coarse[static_cast<std::size_t>((cc.z * (field.ny >> shift) + cc.y) * (field.nx >> shift) + cc.x)];
    const auto half = static_cast<float>(1 << shift) * 0.5f;
    e = {q.x - static_cast<float>(cc.x << shift) - half, q.y - static_cast<float>(cc.y << shift) - half,
         q.z - static_cast<float>(cc.z << shift) - half};
    sample.gradient = CoarseGradientOf(cell.gradient);
    sample.distance = plane(cell.distance, sample.gradient);
    sample.cell = 2.0f * half;
    sample.centre_distance = cell.distance;
  } else if (kind == CellKind::kPlane) {
    sample.gradient = GradientOf(word);
    sample.centre_distance = DistanceOf(word);
    sample.distance = plane(sample.centre_distance, sample.gradient);
  } else {
    const std::uint32_t* const record = &field.creases[std::size_t{RecordOf(word)} * kPlanesPerCrease];
    const float side = (record[0] & kCombineBit) != 0 ? -1.0f : 1.0f;
    const bool is_nested = (record[1] & kCombineBit) != 0;
    float u[kPlanesPerCrease];
    for (std::uint32_t k = 0; k < kPlanesPerCrease; ++k) {
      u[k] = side * plane(DistanceOf(record[k]), GradientOf(record[k]));
    }
    const int a = (u[0] >= u[1]) != is_nested ? 0 : 1;
    const int b = (u[2] >= u[3]) != is_nested ? 2 : 3;
    const int best = u[a] >= u[b] ? a : b;
    sample.distance = side * u[best];
    sample.gradient = GradientOf(record[best]);
    sample.centre_distance = sample.distance;
    sample.centre_offset = 0.0f;
    if (p == q) return sample;
  }
  if (kind == CellKind::kPlane || kind == CellKind::kCoarse) {
    sample.centre_offset = std::sqrt((e.x * e.x + e.y * e.y) + e.z * e.z);
  }
  if (p != q) {
    const float outside = std::max(std::max(std::abs(p.x - q.x), std::abs(p.y - q.y)), std::abs(p.z - q.z));
    sample.distance = std::max(sample.distance, outside);
  }
  return sample;
}

}  // namespace vps
