#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "vps/field/closest_triangle.hpp"

namespace vps {

// Which triangles can be nearer than `reach` to a sample (voxel centre) of which brick. Voxel units.
struct BrickBins {
  std::vector<std::uint32_t> slot_of_brick;  // place in the grid of bricks, x fastest; ascending
  std::vector<std::uint32_t> first;          // of each brick in `triangles`, and the end
  std::vector<std::uint32_t> triangles;      // ascending within a brick

  [[nodiscard]] std::size_t num_bricks() const { return slot_of_brick.size(); }
  [[nodiscard]] std::span<const std::uint32_t> of(std::size_t brick) const {
    return {triangles.data() + first[brick], triangles.data() + first[brick + 1]};
  }
};

// `scratch`, one per brick of the grid, comes back with each place's brick number, or kNoBrick.
constexpr std::uint32_t kNoBrick = 0xffffffffU;
BrickBins BinTriangles(const TriangleField& triangles, const glm::ivec3& grid_bricks, double reach,
                       std::vector<std::uint32_t>* scratch);

}  // namespace vps
