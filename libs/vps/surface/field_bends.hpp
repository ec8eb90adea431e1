#pragma once

#include <cstdint>
#include <vector>

#include "core/parallel_for.hpp"
#include "vps/field/distance_field.hpp"

namespace vps {

// How a distance field bends at the scale of a node: for each length h = 2, 4, 8, ... voxels a grid of cells of that
// edge. From H, the matrix of second differences at spacing h divided by h^2, at places of the cell up to h from the
// surface:
//
//   mean   the mean of H [1/voxel]: what the depth of a patch differs by from the depth at its centre, in the mean
//   most   the greatest eigenvalue of H - 3/4 mean at any of the places: how much less the depth may be than that.
//          Convex edges of G have it.
//   least  the least one: how much more. Reflex edges have it.
//
// A quarter of the mean stays in the bounds, since the mean of a cell is not that of every patch in it (not derived).
struct FieldBends {
  // For kernels (patch_block.hpp). Numbers of the cells of level after level, x fastest, from 1; 0: the surface is
  // farther than h.
  std::vector<std::uint32_t> numbers;
  std::vector<std::uint32_t> begin;  // of each level in `numbers`
  // Four words each: mean xx and yy, zz and xy, xz and yz, most and -least, the lower half first.
  std::vector<std::uint32_t> words;
  std::vector<float> brick_errors;  // the field's error at the surface in each brick, voxels
  // That of places deeper than kDeepestExact, most of them in coarse cells, against the triangles: r.m.s. over the
  // brick, voxels.
  std::vector<float> inner_errors;
};

// Of the brick that holds p [voxels].
float InnerErrorAt(const FieldBends& bends, const DistanceField& field, const glm::vec3& p);

// `workers` share the work; the result is the same without.
FieldBends BuildFieldBends(const DistanceField& field, core::ParallelFor* workers = nullptr);

}  // namespace vps
