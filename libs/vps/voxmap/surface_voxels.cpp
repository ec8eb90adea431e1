#include "vps/voxmap/surface_voxels.hpp"

#include <algorithm>
#include <cmath>

namespace vps {
namespace {

// Slack, in voxels, that keeps the test conservative under rounding: a surface on a voxel border belongs to both sides.
// Not derived: far above the rounding of double (1e-12 at 1e4 voxels), far below any effect on the layers.
constexpr double kSlack = 1e-7;

}  // namespace

TriangleCubeTest::TriangleCubeTest(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 corners[3] = {a, b, c};
  const glm::dvec3 low = glm::min(a, glm::min(b, c)) - kSlack;
  const glm::dvec3 high = glm::max(a, glm::max(b, c)) + kSlack;
  lower_ = glm::ivec3(glm::floor(low));
  upper_ = glm::ivec3(glm::floor(high));

  normal_ = glm::cross(b - a, c - a);
  const double length = glm::length(normal_);
  is_degenerate_ = !(length > 1e-14);
  if (!is_degenerate_) normal_ /= length;
  for (int k = 0; k < 2; ++k) {
    if (std::abs(normal_[k]) > std::abs(normal_[dominant_])) dominant_ = k;
  }
  // normal . q = normal . a somewhere in the cube, where normal . q spans normal . cube + [sum of negative, sum of
  // positive components].
  const double offset = glm::dot(normal_, a);
  const glm::dvec3 positive = glm::max(normal_, glm::dvec3(0.0));
  const glm::dvec3 negative = glm::min(normal_, glm::dvec3(0.0));
  plane_lower_ = offset - (positive.x + positive.y + positive.z) - kSlack;
  plane_upper_ = offset - (negative.x + negative.y + negative.z) + kSlack;

  for (int projection = 0; projection < 3; ++projection) {
    const int u = (projection + 1) % 3;
    const int v = (projection + 2) % 3;
    const double side = normal_[projection] >= 0.0 ? 1.0 : -1.0;
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3 edge = corners[(k + 1) % 3] - corners[k];
      double ea = -edge[v] * side;
      double eb = edge[u] * side;
      const double norm = std::hypot(ea, eb);
      if (norm > 0.0) {
        ea /= norm;
        eb /= norm;
      }
      // Largest value over the unit square must not be negative.
      edges_[projection][k] = {
          ea, eb, -(ea * corners[k][u] + eb * corners[k][v]) + std::max(0.0, ea) + std::max(0.0, eb) + kSlack};
    }
  }
}

void TriangleCubeTest::ColumnRange(const glm::ivec3& cube, int* first, int* last) const {
  *first = lower_[dominant_];
  *last = upper_[dominant_];
  if (is_degenerate_) return;
  const int u = (dominant_ + 1) % 3;
  const int v = (dominant_ + 2) % 3;
  const double n = normal_[dominant_];
  const double rest = normal_[u] * cube[u] + normal_[v] * cube[v];
  const double w0 = (plane_lower_ - rest) / n;
  const double w1 = (plane_upper_ - rest) / n;
  *first = std::max(*first, static_cast<int>(std::ceil(std::min(w0, w1) - kSlack)));
  *last = std::min(*last, static_cast<int>(std::floor(std::max(w0, w1) + kSlack)));
}

bool TriangleCubeTest::Touches(const glm::ivec3& cube) const {
  const glm::dvec3 p(cube);
  if (!is_degenerate_) {
    const double s = glm::dot(normal_, p);
    if (s < plane_lower_ || s > plane_upper_) return false;
  }
  for (int projection = 0; projection < 3; ++projection) {
    const double pu = p[(projection + 1) % 3];
    const double pv = p[(projection + 2) % 3];
    for (const EdgeFunction& e : edges_[projection]) {
      if (e.a * pu + e.b * pv + e.d < 0.0) return false;
    }
  }
  return true;
}

void MarkSurface(const TriangleMesh& mesh, const Voxmap& grid, std::uint8_t mark, std::uint8_t* state) {
  const glm::ivec3 last_cube(grid.nx - 1, grid.ny - 1, grid.nz - 1);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    auto [a, b, c] = mesh.corners(i);
    a = (a - grid.origin_m) / grid.voxel_size_m;
    b = (b - grid.origin_m) / grid.voxel_size_m;
    c = (c - grid.origin_m) / grid.voxel_size_m;
    const TriangleCubeTest test(a, b, c);
    const glm::ivec3 lower = glm::max(test.lower(), glm::ivec3(0));
    const glm::ivec3 upper = glm::min(test.upper(), last_cube);
    const int w = test.dominant_axis();
    const int u = (w + 1) % 3;
    const int v = (w + 2) % 3;
    glm::ivec3 cube;
    for (cube[v] = lower[v]; cube[v] <= upper[v]; ++cube[v]) {
      for (cube[u] = lower[u]; cube[u] <= upper[u]; ++cube[u]) {
        int first = 0;
        int last = -1;
        test.ColumnRange(cube, &first, &last);
        first = std::max(first, lower[w]);
        last = std::min(last, upper[w]);
        for (cube[w] = first; cube[w] <= last; ++cube[w]) {
          if (!test.Touches(cube)) continue;
          state[(static_cast<std::size_t>(cube.z) * grid.ny + cube.y) * grid.nx + cube.x] = mark;
        }
      }
    }
  }
}

}  // namespace vps
