#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// A triangle of a surface, or a part of one. Mesh frame, metres.
struct SurfacePiece {
  glm::vec3 corners[3];
};

// A mesh with more is taken as it is. Not derived: some 380 bytes each with nodes and families, 100 MB.
constexpr std::size_t kMostPieces = 262'144;

// Cuts thin triangles across, and halves the rest across their longest side, until that is at most `longest_m`; with
// more than kMostPieces of them, the triangles as they are. Triangles without area are left out.
std::vector<SurfacePiece> CutIntoPieces(const TriangleMesh& mesh, double longest_m);

}  // namespace vps
