#include "view/shading_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace view {
namespace {

using Index = std::uint32_t;

// For each vertex the number of the first vertex, in sorted order, at the same position.
std::vector<Index> Weld(std::span<const glm::vec3> positions) {
  std::vector<Index> order(positions.size());
  std::iota(order.begin(), order.end(), Index{0});
  const auto less = [&](Index a, Index b) {
    const glm::vec3& p = positions[a];
    const glm::vec3& q = positions[b];
    if (p.x != q.x) return p.x < q.x;
    if (p.y != q.y) return p.y < q.y;
    if (p.z != q.z) return p.z < q.z;
    return a < b;
  };
  std::sort(order.begin(), order.end(), less);
  std::vector<Index> welded(positions.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool is_same = i > 0 && positions[order[i]] == positions[order[i - 1]];
    welded[order[i]] = is_same ? welded[order[i - 1]] : order[i];
  }
  return welded;
}

}  // namespace

void AppendPart(std::span<const glm::vec3> positions_M, std::span<const std::uint32_t> indices,
                const Material& material, ShadingMesh& mesh, double crease_angle_rad) {
  const std::vector<Index> welded = Weld(positions_M);
  const std::size_t num_faces = indices.size() / 3;
  std::vector<glm::vec3> area_normals(num_faces);  // length is twice the area
  std::vector<glm::vec3> unit_normals(num_faces);
  std::vector<Index> first_face(positions_M.size() + 1, 0);  // faces around a welded vertex, by counting sort
  for (std::size_t f = 0; f < num_faces; ++f) {
    const glm::vec3& a = positions_M[indices[3 * f]];
    const glm::vec3 n = glm::cross(positions_M[indices[3 * f + 1]] - a, positions_M[indices[3 * f + 2]] - a);
    area_normals[f] = n;
    const float length = glm::length(n);
    unit_normals[f] = length > 0.0f ? n / length : glm::vec3(0, 0, 1);
    for (std::size_t k = 0; k < 3; ++k) ++first_face[welded[indices[3 * f + k]] + 1];
  }
  std::partial_sum(first_face.begin(), first_face.end(), first_face.begin());
  std::vector<Index> faces(indices.size());
  std::vector<Index> next(first_face.begin(), first_face.end() - 1);
  for (std::size_t c = 0; c < 3 * num_faces; ++c) faces[next[welded[indices[c]]]++] = static_cast<Index>(c / 3);

  const auto first_index = static_cast<Index>(mesh.indices.size());
  const auto min_cosine = static_cast<float>(std::cos(crease_angle_rad) - 1e-6);
  // Corners of one position that got the same normal share one vertex: smooth meshes stay small.
  std::vector<std::vector<Index>> made(positions_M.size());
  for (std::size_t c = 0; c < 3 * num_faces; ++c) {
    const Index vertex = welded[indices[c]];
    const glm::vec3& own = unit_normals[c / 3];
    glm::vec3 sum(0.0f);
    for (Index i = first_face[vertex]; i < first_face[vertex + 1]; ++i) {
      if (glm::dot(unit_normals[faces[i]], own) >= min_cosine) sum += area_normals[faces[i]];
    }
    const float length = glm::length(sum);
    const glm::vec3 normal = length > 0.0f ? sum / length : own;
    const auto same = std::find_if(made[vertex].begin(), made[vertex].end(),
                                   [&](Index i) { return glm::dot(mesh.vertices[i].normal_M, normal) > 0.99999f; });
    if (same != made[vertex].end()) {
      mesh.indices.push_back(*same);
    } else {
      made[vertex].push_back(static_cast<Index>(mesh.vertices.size()));
      mesh.indices.push_back(static_cast<Index>(mesh.vertices.size()));
      mesh.vertices.push_back({positions_M[vertex], normal});
    }
  }
  mesh.parts.push_back({first_index, static_cast<Index>(3 * num_faces), material});
}

void AppendPart(std::span<const glm::vec3> positions_M, std::span<const glm::vec3> normals_M,
                std::span<const std::uint32_t> indices, const Material& material, ShadingMesh& mesh) {
  const auto base = static_cast<Index>(mesh.vertices.size());
  mesh.parts.push_back({static_cast<Index>(mesh.indices.size()), static_cast<Index>(indices.size()), material});
  for (std::size_t i = 0; i < positions_M.size(); ++i) mesh.vertices.push_back({positions_M[i], normals_M[i]});
  for (const Index i : indices) mesh.indices.push_back(base + i);
}

}  // namespace view
