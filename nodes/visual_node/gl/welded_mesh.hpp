#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "vps/mesh/load_mesh.hpp"

namespace visual_node {

// The triangles of all primitives, with an index for each place instead of each vertex.
struct WeldedMesh {
  std::vector<glm::dvec3> places;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // of places, in the order of the primitives
};
WeldedMesh Weld(const vps::VisualMesh& mesh);

// For each place one that stands for all that triangles connect with it.
std::vector<std::uint32_t> ConnectedParts(const WeldedMesh& mesh);

}  // namespace visual_node
