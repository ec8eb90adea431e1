#include "view/shading_mesh.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace view {
namespace {

// A prism with n sides about z, without caps: radius 1, height 1.
void MakePrism(int n, std::vector<glm::vec3>& positions, std::vector<std::uint32_t>& indices) {
  for (int i = 0; i < n; ++i) {
    const double angle = 2.0 * std::acos(-1.0) * i / n;
    positions.emplace_back(std::cos(angle), std::sin(angle), 0.0);
    positions.emplace_back(std::cos(angle), std::sin(angle), 1.0);
  }
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(n); ++i) {
    const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % static_cast<std::uint32_t>(n));
    for (const std::uint32_t k : {a, b, b + 1, a, b + 1, a + 1}) indices.push_back(k);
  }
}

TEST(ShadingMesh, SharpEdgesKeepTheirFaceNormals) {
  std::vector<glm::vec3> positions;
  std::vector<std::uint32_t> indices;
  MakePrism(4, positions, indices);  // edges of 90 degrees
  ShadingMesh mesh;
  AppendPart(positions, indices, {}, mesh);
  EXPECT_EQ(mesh.vertices.size(), 16u);  // two normals at each of the 8 corners
  for (std::size_t c = 0; c < mesh.indices.size(); ++c) {
    const glm::vec3& a = mesh.vertices[mesh.indices[3 * (c / 3)]].position_M;
    const glm::vec3& b = mesh.vertices[mesh.indices[3 * (c / 3) + 1]].position_M;
    const glm::vec3& d = mesh.vertices[mesh.indices[3 * (c / 3) + 2]].position_M;
    const glm::vec3 face = glm::normalize(glm::cross(b - a, d - a));
    EXPECT_NEAR(glm::dot(face, mesh.vertices[mesh.indices[c]].normal_M), 1.0f, 1e-6f);
  }
}

TEST(ShadingMesh, RoundSurfacesAreSmooth) {
  std::vector<glm::vec3> positions;
  std::vector<std::uint32_t> indices;
  MakePrism(24, positions, indices);  // edges of 15 degrees
  ShadingMesh mesh;
  AppendPart(positions, indices, {}, mesh);
  for (const ShadingMesh::Vertex& vertex : mesh.vertices) {
    const glm::vec3 radial = glm::normalize(glm::vec3(vertex.position_M.x, vertex.position_M.y, 0.0f));
    // A vertex sees two triangles of one side and one of the other, so the area-weighted mean leans to the first by at
    // most 7.5 degrees / 3.
    EXPECT_GT(glm::dot(vertex.normal_M, radial), std::cos(0.0437f) - 1e-5f);
  }
}

TEST(ShadingMesh, PartsKeepTheirMaterialsAndIndices) {
  std::vector<glm::vec3> positions;
  std::vector<std::uint32_t> indices;
  MakePrism(6, positions, indices);
  ShadingMesh mesh;
  AppendPart(positions, indices, {.base_color = glm::vec3(1, 0, 0)}, mesh);
  const std::vector<glm::vec3> normals(positions.size(), glm::vec3(0, 0, 1));
  AppendPart(positions, normals, indices, {.base_color = glm::vec3(0, 1, 0)}, mesh);
  ASSERT_EQ(mesh.parts.size(), 2u);
  EXPECT_EQ(mesh.parts[1].first_index, indices.size());
  EXPECT_EQ(mesh.parts[1].material.base_color, glm::vec3(0, 1, 0));
  EXPECT_EQ(mesh.vertices[mesh.indices.back()].normal_M, glm::vec3(0, 0, 1));
}

}  // namespace
}  // namespace view
