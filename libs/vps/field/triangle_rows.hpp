#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>

namespace vps {

constexpr int kRow = 8;

// A triangle made ready for the distances of whole rows of points, in single precision about a local origin: three
// edges, and the prism over the face. Errors stay below 1e-3 voxel while its corners are within some thousand voxels.
struct RowTriangle {
  RowTriangle() = default;
  // Corners relative to the local origin.
  RowTriangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);

  struct Edge {
    glm::vec3 start{0.0f};
    glm::vec3 along{0.0f};
    float inverse_squared_length = 0.0f;
    glm::vec3 inward{0.0f};  // normal of the edge in the triangle's plane
  };
  Edge edges[3];
  glm::vec3 lower{0.0f}, upper{0.0f};
  glm::vec3 normal{0.0f};
  float offset = 0.0f;        // normal . p of the plane
  float prism_margin = 0.0f;  // infinite: no area, the edges are all there is

  // Whether p lies over the face, inside the prism of its edges.
  [[nodiscard]] bool IsOverFace(const glm::vec3& p) const {
    float least = glm::dot(p - edges[0].start, edges[0].inward);
    least = std::min(least, glm::dot(p - edges[1].start, edges[1].inward));
    return std::min(least, glm::dot(p - edges[2].start, edges[2].inward)) >= prism_margin;
  }
  [[nodiscard]] float Height(const glm::vec3& p) const { return glm::dot(normal, p) - offset; }
};

struct PointRow {
  float x[kRow], y[kRow], z[kRow];
};
// Squared distances of eight points to the nearest of the triangles, and its place in `near`.
struct NearTriangle {
  std::uint32_t number = 0;
  const RowTriangle* rows = nullptr;
};
void FindNearest(std::span<const NearTriangle> near, const PointRow& points, float* squared, std::uint32_t* nearest);

// Squared distances to the triangle of the samples (0 ... 7, y, z) of a brick. False when all of them are farther than
// `reach`, by a quick test.
bool SampleDistances(const RowTriangle& triangle, int y, int z, float reach, float* squared);

// Nearest triangle of the samples of a brick, 0, 1, ..., 7 in each direction, x fastest. Starts with every distance at
// the square of the reach.
struct NearestSamples {
  float squared[512];
  std::uint32_t triangle[512];
};

// Takes the triangle into account: where it is nearer than what was, its number is kept. Samples farther than `reach`
// may be left out.
void AddTriangle(const RowTriangle& triangle, std::uint32_t number, float reach, NearestSamples* samples);

}  // namespace vps
