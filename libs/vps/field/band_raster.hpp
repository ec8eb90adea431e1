#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "vps/field/closest_triangle.hpp"
#include "vps/field/distance_field.hpp"

namespace vps {

// Nearest triangle of every sample (voxel centre) within the band, in bricks that are made when a triangle first
// reaches them. Voxel units.
struct BandBricks {
  static constexpr std::uint32_t kNone = 0xffffffffU;
  struct Brick {
    glm::ivec3 cell{0};  // in bricks
    float squared_distance[DistanceField::kBrickWords];
    std::uint32_t triangle[DistanceField::kBrickWords];
  };

  int bx = 0, by = 0, bz = 0;
  std::vector<std::uint32_t> index;  // brick number or kNone, x fastest
  std::vector<std::unique_ptr<Brick>> bricks;

  // Nearest triangle of a sample, or kNone.
  [[nodiscard]] std::uint32_t TriangleAt(const glm::ivec3& voxel) const;
};

// Every triangle visits the samples within `band` of it, row by row: cost grows with the area of the surface, not with
// the volume. Triangles must lie inside the grid.
BandBricks RasterBand(const TriangleField& triangles, const glm::ivec3& grid_bricks, double band);

}  // namespace vps
