#include "nodes/visual_node/gl/closed_mesh.hpp"

#include <array>
#include <cstdint>
#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

namespace visual_node {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

// The triangles of all primitives, with an index for each place instead of each vertex.
std::vector<Triangle> WeldedTriangles(const vps::VisualMesh& mesh, std::vector<glm::dvec3>* places) {
  std::map<std::array<float, 3>, std::uint32_t> known;
  std::vector<Triangle> triangles;
  for (const vps::VisualPrimitive& primitive : mesh.primitives) {
    std::vector<std::uint32_t> place_of;
    for (const glm::vec3& p : primitive.positions) {
      const auto [it, is_new] = known.try_emplace({p.x, p.y, p.z}, static_cast<std::uint32_t>(places->size()));
      if (is_new) places->emplace_back(p);
      place_of.push_back(it->second);
    }
    for (std::size_t i = 0; i + 2 < primitive.indices.size(); i += 3) {
      const std::uint32_t* corner = &primitive.indices[i];
      triangles.push_back({place_of[corner[0]], place_of[corner[1]], place_of[corner[2]]});
    }
  }
  return triangles;
}

bool EveryEdgeIsMet(const std::vector<Triangle>& triangles) {
  std::unordered_map<std::uint64_t, int> surplus;  // of triangles that go along an edge from its lower place
  for (const Triangle& t : triangles) {
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
bool EveryPartIsPositive(const std::vector<Triangle>& triangles, const std::vector<glm::dvec3>& places) {
  std::vector<std::uint32_t> part(places.size());
  for (std::uint32_t i = 0; i < part.size(); ++i) part[i] = i;
  const auto root = [&](std::uint32_t i) {
    while (part[i] != i) i = part[i] = part[part[i]];
    return i;
  };
  for (const Triangle& t : triangles) {
    part[root(t[0])] = root(t[1]);
    part[root(t[1])] = root(t[2]);
  }
  std::unordered_map<std::uint32_t, double> volume;
  for (const Triangle& t : triangles) {
    volume[root(t[0])] += glm::dot(places[t[0]], glm::cross(places[t[1]], places[t[2]]));
  }
  for (const auto& [first, sum] : volume) {
    if (sum <= 0.0) return false;
  }
  return true;
}

}  // namespace

bool IsClosedAndFacesOutwards(const vps::VisualMesh& mesh) {
  std::vector<glm::dvec3> places;
  const std::vector<Triangle> triangles = WeldedTriangles(mesh, &places);
  return !triangles.empty() && EveryEdgeIsMet(triangles) && EveryPartIsPositive(triangles, places);
}

}  // namespace visual_node
