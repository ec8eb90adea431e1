#pragma once

#include <array>
#include <glm/glm.hpp>
#include <vector>

#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// Where a surface is sharp and stands out, so that a contact can be as small as it is deep: edges at which the outward
// normals of the two faces part by more than kSharpAngle_deg, open rims, and the corners in which such edges end,
// branch or bend by as much. Mesh frame, metres.
struct SharpEdges {
  std::vector<std::array<glm::dvec3, 2>> segments;
  std::vector<glm::dvec3> corners;
  double length_m = 0.0;
};

constexpr double kSharpAngle_deg = 25.0;
SharpEdges FindSharpEdges(const TriangleMesh& mesh);

}  // namespace vps
