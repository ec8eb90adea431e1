#include "nodes/visual_node/gl/closed_mesh.hpp"

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "nodes/visual_node/gl/welded_mesh.hpp"

namespace visual_node {
namespace {

bool EveryEdgeIsMet(const WeldedMesh& mesh) {
  std::unordered_map<std::uint64_t, int> surplus;  // of triangles that go along an edge from its lower place
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint64_t from = t[i], to = t[(i + 1) % 3];
      if (from < to) ++surplus[from << 32U | to];
      if (to < from) --surplus[to << 32U | from];
    }
  }
  for (const auto& [edge, number] : surplus) {
    if (number != 0) return false;
  }
  return true;
}

// By the divergence theorem a closed surface encloses the sum of a . (b x c) / 6 over its triangles.
bool EveryPartIsPositive(const WeldedMesh& mesh) {
  const std::vector<std::uint32_t> part = ConnectedParts(mesh);
  std::unordered_map<std::uint32_t, double> volume;
  for (const auto& [a, b, c] : mesh.triangles) {
    volume[part[a]] += glm::dot(mesh.places[a], glm::cross(mesh.places[b], mesh.places[c]));
  }
  for (const auto& [first, sum] : volume) {
    if (sum <= 0.0) return false;
  }
  return true;
}

}  // namespace

bool IsClosedAndFacesOutwards(const vps::VisualMesh& mesh) {
  const WeldedMesh welded = Weld(mesh);
  return !welded.triangles.empty() && EveryEdgeIsMet(welded) && EveryPartIsPositive(welded);
}

}  // namespace visual_node
