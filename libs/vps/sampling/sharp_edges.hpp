#pragma once

#include <array>
#include <glm/glm.hpp>
#include <vector>

#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// Convex sharp features, where a contact can be as small as it is deep: edges at which the outward normals of the two
// faces differ by more than kSharpAngle_deg, open borders, and the corners in which such edges end, branch or turn by
// as much. Mesh frame, metres.
struct SharpEdges {
  std::vector<std::array<glm::dvec3, 2>> segments;
  std::vector<glm::dvec3> corners;
  double length_m = 0.0;
};

// Not derived; the edges of a finely tessellated round part (5.6 degrees for 64 segments) stay below it.
constexpr double kSharpAngle_deg = 25.0;
SharpEdges FindSharpEdges(const TriangleMesh& mesh);

}  // namespace vps
