#include "vps/sampling/sharp_edges.hpp"

#include <cmath>
#include <numbers>

#include "vps/mesh/edge_table.hpp"

namespace vps {
namespace {

const double kCosSharp = std::cos(kSharpAngle_deg * std::numbers::pi / 180.0);

glm::dvec3 Normal(const TriangleMesh& mesh, std::uint32_t triangle) {
  const auto [a, b, c] = mesh.corners(triangle);
  const glm::dvec3 n = glm::cross(b - a, c - a);
  const double length = glm::length(n);
  return length > 0.0 ? n / length : glm::dvec3(0.0);
}

// Of two triangles that share an edge. Convex: the second one's third corner lies below the first one's plane.
bool IsSharpAndConvex(const TriangleMesh& mesh, const EdgeUse& first, const EdgeUse& second) {
  const glm::dvec3 n = Normal(mesh, first.triangle);
  const glm::dvec3 m = Normal(mesh, second.triangle);
  if (n == glm::dvec3(0.0) || m == glm::dvec3(0.0) || glm::dot(n, m) > kCosSharp) return false;
  const auto& t = mesh.triangles[second.triangle];
  return glm::dot(n, mesh.vertices[t[(second.corner + 2) % 3]] - mesh.vertices[t[second.corner]]) < 0.0;
}

}  // namespace

SharpEdges FindSharpEdges(const TriangleMesh& mesh) {
  SharpEdges sharp;
  struct Meeting {
    int count = 0;
    glm::dvec3 first{0.0};  // direction of the first edge, away from the vertex
    bool is_bent = false;
  };
  std::vector<Meeting> meetings(mesh.vertices.size());
  const auto meet = [&](std::uint32_t vertex, const glm::dvec3& direction) {
    Meeting& meeting = meetings[vertex];
    if (++meeting.count == 1) meeting.first = direction;
    // Along a straight edge the two directions are opposite.
    if (meeting.count == 2) meeting.is_bent = glm::dot(meeting.first, direction) > -kCosSharp;
  };
  const std::vector<EdgeUse> edges = SortedEdges(mesh);
  for (std::size_t i = 0; i < edges.size();) {
    const std::size_t end = EndOfEdge(edges, i);
    if (end - i != 2 || IsSharpAndConvex(mesh, edges[i], edges[i + 1])) {
      const auto low = static_cast<std::uint32_t>(edges[i].key >> 32);
      const auto high = static_cast<std::uint32_t>(edges[i].key);
      const glm::dvec3 along = mesh.vertices[high] - mesh.vertices[low];
      const double length = glm::length(along);
      if (length > 0.0) {
        sharp.segments.push_back({mesh.vertices[low], mesh.vertices[high]});
        sharp.length_m += length;
        meet(low, along / length);
        meet(high, -along / length);
      }
    }
    i = end;
  }
  for (std::size_t v = 0; v < meetings.size(); ++v) {
    if (meetings[v].count != 0 && (meetings[v].count != 2 || meetings[v].is_bent)) {
      sharp.corners.push_back(mesh.vertices[v]);
    }
  }
  return sharp;
}

}  // namespace vps
