#pragma once

#include <array>
#include <cstdint>

#include "vps/field/distance_field.hpp"

namespace vps {

// A brick's words ([z * 64 + y * 8 + x]) and those of the 26 around it, x fastest.
using Neighbourhood = std::array<const std::uint32_t*, 27>;

// Word of the cell (x, y, z), each in -1 ... 8, seen from the middle brick.
inline const std::uint32_t& WordAt(const Neighbourhood& bricks, int x, int y, int z) {
  const int brick = (((z + 8) >> 3) * 3 + ((y + 8) >> 3)) * 3 + ((x + 8) >> 3);
  return bricks[static_cast<std::size_t>(brick)][(z & 7) << 6 | (y & 7) << 3 | (x & 7)];
}

// Cells of a brick whose plane may miss somewhere in the cell: [z * 8 + y], bit x.
using CreaseCells = std::array<std::uint8_t, 64>;

// Cells of a brick, examined by the planes of the brick and of the cells around it, before any crease is fitted.
struct ExaminedCells {
  CreaseCells creases{};
  // Of the other cells near the surface: what to add to the distance of the plane, 1/256 voxel, [z * 64 + y * 8 + x].
  // A tangent plane at the centre lies on one side of a curved distance; d(e) = d + g . e + e . H e / 2 has the mean
  // d + tr(H) / 24 over a cell of edge 1, and tr(H) is the sum of second differences of the centres' distances.
  std::array<std::int8_t, 512> lifts{};
};
ExaminedCells ExamineCells(const Neighbourhood& bricks);

}  // namespace vps
