#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "vps/sampling/point_block.hpp"

namespace vps {

// The points of a sphere of level 0 lie also between two planes, `h` on either side of the centre, across the unit
// normal n; h and n are 0 in the other levels and where the points have no common direction.
struct alignas(64) SphereBlock {
  float x[kBlock], y[kBlock], z[kBlock], r[kBlock];  // m; r is padded against rounding
  float nx[kBlock], ny[kBlock], nz[kBlock], h[kBlock];
};

// Spheres of an implicit tree with sixteen children: sphere j of level 0 holds leaf j, sphere j of level k the sphere
// block j of level k - 1. The last level is one block. Blocks are filled up with spheres far away.
struct SphereTree {
  static constexpr std::uint32_t kMaxLevels = 7;
  static constexpr float kFarAway_m = 1e6f;

  std::vector<SphereBlock> spheres;                     // level after level
  std::array<std::uint32_t, kMaxLevels> level_begin{};  // first block of each level
  std::uint32_t num_levels = 0;
};

// An order in which aligned runs of 16, 256, 4096 ... places are compact.
std::vector<std::uint32_t> OrderInRuns(const std::vector<glm::dvec3>& places_m);

// Leaf j holds the places from j kBlock on, the last one may hold fewer. `leaf_normals`: the direction across its slab,
// unit or zero.
SphereTree BuildSphereTree(std::span<const glm::vec3> places_m, std::span<const glm::vec3> leaf_normals);

// Whether levels, blocks and fillers fit a tree over so many leaves.
bool IsConsistent(const SphereTree& tree, std::size_t num_leaves);

}  // namespace vps
