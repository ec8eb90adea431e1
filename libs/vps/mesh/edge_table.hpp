#pragma once

#include <cstdint>
#include <vector>

#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// An edge of one triangle, from corner k to corner k + 1.
struct EdgeUse {
  std::uint64_t key = 0;  // smaller vertex << 32 | larger
  std::uint32_t triangle = 0;
  std::uint32_t corner = 0;
  bool is_forward = false;  // from the smaller vertex to the larger
};

// All of them, those of one edge side by side.
std::vector<EdgeUse> SortedEdges(const TriangleMesh& mesh);

// First entry after `begin` that belongs to another edge.
std::size_t EndOfEdge(const std::vector<EdgeUse>& edges, std::size_t begin);

// The boundary of the surface as closed loops of vertices. Where n triangles pass an edge one way and m the other, it
// counts n - m times; this boundary of the sum of all triangles has no boundary itself, so that loops always close,
// however badly the triangles are connected. Loops run as the triangles do: surface on the left seen from outside.
std::vector<std::vector<std::uint32_t>> BoundaryLoops(const TriangleMesh& mesh);

}  // namespace vps
