#include "vps/mesh/vertex_normals.hpp"

#include <cmath>

namespace vps {

VisualPrimitive SplitAtCreases(const TriangleMesh& mesh, double crease_rad) {
  const double min_cosine = std::cos(crease_rad);
  std::vector<glm::dvec3> area_normals;  // twice the area times the unit normal
  std::vector<std::vector<std::uint32_t>> faces_of(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = mesh.corners(i);
    area_normals.push_back(glm::cross(b - a, c - a));
    for (const std::uint32_t v : mesh.triangles[i]) faces_of[v].push_back(static_cast<std::uint32_t>(i));
  }
  const auto unit = [](const glm::dvec3& v) {
    const double length = glm::length(v);
    return length > 0.0 ? v / length : glm::dvec3(0, 0, 1);
  };
  VisualPrimitive out;
  std::vector<std::vector<std::uint32_t>> drawn_of(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const glm::dvec3 own = unit(area_normals[i]);
    for (const std::uint32_t v : mesh.triangles[i]) {
      glm::dvec3 sum(0.0);
      for (const std::uint32_t face : faces_of[v]) {
        if (glm::dot(unit(area_normals[face]), own) >= min_cosine) sum += area_normals[face];
      }
      const glm::vec3 normal(unit(sum));
      std::uint32_t drawn = 0xffffffffU;
      for (const std::uint32_t candidate : drawn_of[v]) {
        if (glm::dot(out.normals[candidate], normal) > 0.99999f) drawn = candidate;
      }
      if (drawn == 0xffffffffU) {
        drawn = static_cast<std::uint32_t>(out.positions.size());
        out.positions.emplace_back(mesh.vertices[v]);
        out.normals.push_back(normal);
        drawn_of[v].push_back(drawn);
      }
      out.indices.push_back(drawn);
    }
  }
  return out;
}

}  // namespace vps
