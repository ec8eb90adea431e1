#include "vps/mesh/triangle_mesh.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <unordered_map>

#include "core/hash.hpp"

namespace vps {

Box BoundingBox(const TriangleMesh& mesh) {
  Box box{glm::dvec3(std::numeric_limits<double>::infinity()), glm::dvec3(-std::numeric_limits<double>::infinity())};
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t v : triangle) {
      box.lower = glm::min(box.lower, mesh.vertices[v]);
      box.upper = glm::max(box.upper, mesh.vertices[v]);
    }
  }
  return box;
}

double SurfaceArea_m2(const TriangleMesh& mesh) {
  double area_m2 = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b, c] = mesh.corners(t);
    area_m2 += 0.5 * glm::length(glm::cross(b - a, c - a));
  }
  return area_m2;
}

TriangleMesh MergeDuplicateVertices(const TriangleMesh& mesh) {
  struct Hasher {
    std::size_t operator()(const glm::dvec3& p) const { return core::Hash64(&p, sizeof(p)); }
  };
  TriangleMesh merged;
  std::unordered_map<glm::dvec3, std::uint32_t, Hasher> index_of;
  index_of.reserve(mesh.vertices.size());
  for (const auto& triangle : mesh.triangles) {
    std::array<std::uint32_t, 3> t{};
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3 p = mesh.vertices[triangle[k]] + 0.0;  // -0 becomes +0: equal positions have equal bytes
      const auto [entry, is_new] = index_of.try_emplace(p, static_cast<std::uint32_t>(merged.vertices.size()));
      if (is_new) merged.vertices.push_back(p);
      t[k] = entry->second;
    }
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) merged.triangles.push_back(t);
  }
  return merged;
}

std::size_t CountOpenEdges(const TriangleMesh& mesh) {
  // A directed edge (a, b) counts +1, its reverse -1: each undirected edge of a closed mesh sums to zero.
  std::vector<std::pair<std::uint64_t, int>> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const std::uint64_t a = t[k];
      const std::uint64_t b = t[(k + 1) % 3];
      edges.emplace_back(a < b ? (a << 32 | b) : (b << 32 | a), a < b ? 1 : -1);
    }
  }
  std::sort(edges.begin(), edges.end());
  std::size_t num_open = 0;
  for (std::size_t i = 0; i < edges.size();) {
    int sum = 0;
    std::size_t j = i;
    for (; j < edges.size() && edges[j].first == edges[i].first; ++j) sum += edges[j].second;
    if (sum != 0) ++num_open;
    i = j;
  }
  return num_open;
}

}  // namespace vps
