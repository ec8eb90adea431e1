#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "view/scene.hpp"

namespace view {

// A triangle mesh ready for shading: each corner has its own normal where the surface has an edge.
struct ShadingMesh {
  struct Vertex {
    glm::vec3 position_M{0.0f};  // m
    glm::vec3 normal_M{0.0f, 0.0f, 1.0f};
  };
  struct Part {  // a run of indices with one material
    std::uint32_t first_index = 0;
    std::uint32_t num_indices = 0;
    Material material;
  };
  std::vector<Vertex> vertices;
  std::vector<std::uint32_t> indices;  // three per triangle, counter-clockwise seen from outside
  std::vector<Part> parts;
};

constexpr double kCreaseAngle_rad = 0.5235987755982988;  // 30 degrees

// Adds triangles as one part. A corner's normal is the mean, weighted by area, of the normals of those faces around its
// position that differ from its own face's by at most the crease angle. Vertices at bitwise equal positions are one.
void AppendPart(std::span<const glm::vec3> positions_M, std::span<const std::uint32_t> indices,
                const Material& material, ShadingMesh& mesh, double crease_angle_rad = kCreaseAngle_rad);

// The same with normals that the file gave, one per position.
void AppendPart(std::span<const glm::vec3> positions_M, std::span<const glm::vec3> normals_M,
                std::span<const std::uint32_t> indices, const Material& material, ShadingMesh& mesh);

}  // namespace view
