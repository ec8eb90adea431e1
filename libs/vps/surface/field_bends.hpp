#pragma once

#include <array>
#include <vector>

#include "vps/field/distance_field.hpp"

namespace vps {

// How a distance field bends at the scale of a node: for each length h = 2, 4, 8, ... voxels a grid of cells of that
// edge. From H, the matrix of second differences at spacing h divided by h^2, at places of the cell up to h from the
// surface:
//
//   mean        the mean of H [1/voxel]: what the depth of a patch differs by from the depth at its centre, in the
//   mean, most, least the greatest and the least eigenvalue of H - 3/4 mean at any of the places: how much less, and
//   how much
//               more, the depth may be than by the mean. Convex edges of G have the first, reflex ones the second.
//
// A quarter of the mean stays in the bounds, since the mean of a cell is not that of every patch in it (not derived).
class FieldBends {
 public:
  explicit FieldBends(const DistanceField& field);

  // For kernels (patch_block.hpp). Numbers of the cells of level after level, x fastest, from 1; 0: the surface is
  // farther than h.
  [[nodiscard]] const std::vector<std::uint32_t>& numbers() const { return numbers_; }
  // Where a level begins in numbers().
  [[nodiscard]] const std::vector<std::uint32_t>& begin() const { return begin_; }
  // Four words each: mean xx and yy, zz and xy, xz and yz, most and -least, the lower half first.
  [[nodiscard]] const std::vector<std::uint32_t>& words() const { return words_; }
  // The field's error in each brick, voxels.
  [[nodiscard]] const std::vector<float>& brick_errors() const { return brick_errors_; }

 private:
  void Fill(const DistanceField& field, int shift);

  std::vector<std::uint32_t> numbers_, begin_, words_;
  std::vector<float> brick_errors_;
};

}  // namespace vps
