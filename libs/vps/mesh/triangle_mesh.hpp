#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace vps {

// Triangles in the mesh frame, metres. Counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<glm::dvec3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  [[nodiscard]] std::array<glm::dvec3, 3> corners(std::size_t triangle) const {
    const auto& t = triangles[triangle];
    return {vertices[t[0]], vertices[t[1]], vertices[t[2]]};
  }
};

struct Box {
  glm::dvec3 lower{0.0};
  glm::dvec3 upper{0.0};
};

// Smallest box, parallel to the axes, of the vertices that triangles use.
Box BoundingBox(const TriangleMesh& mesh);

double SurfaceArea_m2(const TriangleMesh& mesh);

// One vertex per distinct position (STL repeats corners, OBJ and glTF split them at seams); triangles that collapse to
// a line or a point are dropped, and so are vertices that no triangle uses.
TriangleMesh MergeDuplicateVertices(const TriangleMesh& mesh);

// Edges that do not have exactly one triangle on each side, oppositely oriented. 0: closed and consistently oriented.
std::size_t CountOpenEdges(const TriangleMesh& mesh);

}  // namespace vps
