#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

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

// A triangle near the centre of a cell. The distance to it is a convex function: it lies above its tangent there.
struct NearTriangle {
  std::uint32_t number = 0;
  const RowTriangle* rows = nullptr;
  float squared = 0.0f;  // distance from the centre
  float tangent = 0.0f;  // the same, lowered for rounding; 0 of triangles too close for a tangent bound, whose way is 0
  glm::vec3 way{0.0f};   // to the centre from the triangle's nearest point
};

// Boxes and planes of some triangles, eight side by side.
class TriangleBounds {
 public:
  explicit TriangleBounds(std::span<const RowTriangle> triangles);

  // Bit i: triangle 8 * group + i may be within `reach` of the points (first_x ... last_x, y, z).
  [[nodiscard]] std::uint32_t FindReaching(std::size_t group, float first_x, float last_x, float y, float z,
                                           float reach) const;
  [[nodiscard]] std::size_t num_groups() const { return groups_.size(); }

 private:
  struct Group {
    float lower[3][kRow], upper[3][kRow];
    float normal[3][kRow], offset[kRow];
  };
  std::vector<Group> groups_;
};

// For each sample (x, y, z), x = 0 ... 7, of a brick with reach[x] >= 0: the triangles within reach[x], in their order.
// `bounds`: of the triangles; `numbers`: their indices in the mesh.
void FindNear(std::span<const RowTriangle> triangles, const TriangleBounds& bounds,
              std::span<const std::uint32_t> numbers, int y, int z, const float* reach,
              std::array<std::vector<NearTriangle>, kRow>* near);

// Nearest triangles of points around the centre of a cell, eight to a row.
constexpr int kNearRows = 3;
struct NearestOfPoints {
  float height[kNearRows * kRow];            // over the triangle's plane
  std::uint32_t triangle[kNearRows * kRow];  // place in `near`; of several equally near ones the first
  bool is_over_face[kNearRows * kRow];
};
// `offsets`: of the points from the centre, at most a voxel long.
void FindNearest(std::span<const NearTriangle> near, const glm::vec3& centre, const PointRow* offsets,
                 NearestOfPoints* out);

// Nearest triangle of the samples of a brick, 0, 1, ..., 7 in each direction, x fastest.
struct NearestSamples {
  // None is nearer than `reach` yet; their triangle is `none`.
  NearestSamples(float reach, std::uint32_t none);

  float squared[512];
  std::uint32_t triangle[512];
};

// Keeps the triangle's number where it is nearer than the nearest so far.
void AddTriangle(const RowTriangle& triangle, std::uint32_t number, float reach, NearestSamples* samples);

}  // namespace vps
