#include "vps/surface/surface_pieces.hpp"

#include "vps/mesh/cut_triangle.hpp"

namespace vps {
namespace {

// False: it has no area.
bool MakePiece(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, SurfacePiece* piece) {
  *piece = {{glm::vec3(a), glm::vec3(b), glm::vec3(c)}};
  return glm::cross(piece->corners[1] - piece->corners[0], piece->corners[2] - piece->corners[0]) != glm::vec3(0.0f);
}

}  // namespace

std::vector<SurfacePiece> CutIntoPieces(const TriangleMesh& mesh, double longest_m) {
  std::vector<SurfacePiece> pieces;
  bool are_few = true;
  SurfacePiece piece;
  for (std::size_t t = 0; t < mesh.triangles.size() && are_few; ++t) {
    are_few = CutTriangle(mesh.corners(t), longest_m, [&](const auto& a, const auto& b, const auto& c) {
      if (MakePiece(a, b, c, &piece)) pieces.push_back(piece);
      return pieces.size() <= kMostPieces;
    });
  }
  if (are_few) return pieces;
  pieces.clear();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b, c] = mesh.corners(t);
    if (MakePiece(a, b, c, &piece)) pieces.push_back(piece);
  }
  return pieces;
}

}  // namespace vps
