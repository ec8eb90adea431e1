#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "vps/mesh/triangle_mesh.hpp"
#include "vps/surface/patch_block.hpp"
#include "vps/surface/surface_pieces.hpp"

namespace vps {

// A part of a surface and its moments about its centroid c. With places x of the part, e = x - c, and the unit inward
// normal n there:
//
//   a = integral of dA,   A = integral of n dA,   N = integral of n e^T dA,   Q = integral of e e^T dA.
//
// They suffice to integrate a depth that varies linearly, in closed form (README.md). Mesh frame.
struct SurfaceNode {
  glm::vec3 centre_m{0.0f};             // c
  float radius_m = 0.0f;                // of a ball about c that holds the part
  float area_m2 = 0.0f;                 // a
  glm::vec3 area_vector_m2{0.0f};       // A
  glm::mat3 normal_moment_m3{0.0f};     // N; column j: integral of n e_j
  std::array<float, 6> spread_m4 = {};  // Q: xx, yy, zz, xy, xz, yz
  // With n = A / |A| the surface is  e . n = 1/2 (e^T K e - tr(K Q) / a)  but for `thickness_m` at most; K n = 0, and 0
  // of a triangle.
  std::array<float, 6> curvature_per_m = {};  // K, in the same order
  float thickness_m = 0.0f;
  std::uint32_t first = 0;         // of the children in SurfaceTree::nodes; of a leaf: its triangle
  std::uint32_t num_children = 0;  // 0: a leaf
};

SurfaceNode NodeOf(const SurfacePiece& triangle);

// The children of a node side by side, in the rows of a PatchBlock; those behind the last have no area.
struct alignas(16) SurfaceFamily {
  float of[kNodeRows][kFamilySize] = {};
  std::uint32_t below[kFamilySize] = {};  // the family of its children; of a leaf: its triangle
};
SurfaceFamily FamilyOf(std::span<const SurfaceNode> children);

// A surface as a tree with up to four children a node and one triangle a leaf. The first `num_roots` nodes have no
// parent; they are the first family.
struct SurfaceTree {
  std::vector<SurfaceNode> nodes;
  std::vector<SurfaceFamily> families;
  std::vector<SurfacePiece> triangles;
  std::uint32_t num_roots = 0;
  double area_m2 = 0.0;
};

// Triangles are cut to `longest_m` first, so that nodes are compact (CutIntoPieces).
SurfaceTree BuildSurfaceTree(const TriangleMesh& mesh, double longest_m);

}  // namespace vps
