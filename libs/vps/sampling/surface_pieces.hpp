#pragma once

#include "vps/mesh/triangle_mesh.hpp"
#include "vps/sampling/sphere_tree.hpp"

namespace vps {

// A triangle of a surface, or a part of one. Mesh frame, metres.
struct SurfacePiece {
  glm::vec3 corners[3];
};

// The sampled surface itself, for the nearest places of a tool (gap/, FindNearestPiece). Sphere j of level 0 holds
// piece j. Triangles without area are left out.
struct SurfacePieces : SphereTree {
  std::vector<SurfacePiece> pieces;

  [[nodiscard]] std::size_t num_bytes() const {
    return pieces.size() * sizeof(SurfacePiece) + spheres.size() * sizeof(SphereBlock);
  }
};

// A mesh with more gets none. Not derived: 68 bytes each, 18 MB.
constexpr std::size_t kMostPieces = 262'144;

// Cuts thin triangles across, and halves the rest across their longest side, until that is at most `longest_m`. Empty
// when there would be more than kMostPieces.
SurfacePieces CutIntoPieces(const TriangleMesh& mesh, double longest_m);
// The number of CutIntoPieces' pieces, without storing them.
std::size_t CountPieces(const TriangleMesh& mesh, double longest_m);

}  // namespace vps
