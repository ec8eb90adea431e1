#include "vps/sampling/surface_panels.hpp"

#include <algorithm>
#include <numeric>

#include "vps/mesh/cut_triangle.hpp"

namespace vps {
namespace {

constexpr std::size_t kTrianglesOfBlock = 16;  // free: enough blocks for all workers, whatever the mesh

// Calls take(panel) for those of one block of triangles.
template <class Take>
void ForPanels(const TriangleMesh& mesh, std::size_t block, double longest_m, const Take& take) {
  const std::size_t end = std::min((block + 1) * kTrianglesOfBlock, mesh.triangles.size());
  for (std::size_t t = block * kTrianglesOfBlock; t < end; ++t) {
    const std::array<glm::dvec3, 3> corners = mesh.corners(t);
    const glm::dvec3 across = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    const double length = glm::length(across);
    if (!(length > 0.0)) continue;
    CutTriangle(corners, longest_m, [&](const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
      const glm::dvec3 middle = (a + b + c) / 3.0;
      take(SurfacePanel{middle, across / length, 0.5 * glm::length(glm::cross(b - a, c - a)),
                        std::max({glm::length(a - middle), glm::length(b - middle), glm::length(c - middle)})});
      return true;
    });
  }
}

}  // namespace

std::vector<std::size_t> CountPanels(const TriangleMesh& mesh, double longest_m, core::ParallelFor* workers) {
  const std::size_t num_blocks = (mesh.triangles.size() + kTrianglesOfBlock - 1) / kTrianglesOfBlock;
  std::vector<std::size_t> begins(num_blocks + 1, 0);
  core::ForEach(workers, num_blocks, [&](std::size_t block) {
    std::size_t count = 0;  // apart from begins, whose cache lines other workers write to
    ForPanels(mesh, block, longest_m, [&](const SurfacePanel&) { ++count; });
    begins[block + 1] = count;
  });
  std::partial_sum(begins.begin(), begins.end(), begins.begin());
  return begins;
}

std::vector<SurfacePanel> MakePanels(const TriangleMesh& mesh, double longest_m, std::span<const std::size_t> begins,
                                     core::ParallelFor* workers) {
  std::vector<SurfacePanel> panels(begins.back());
  core::ForEach(workers, begins.size() - 1, [&](std::size_t block) {
    std::size_t at = begins[block];
    ForPanels(mesh, block, longest_m, [&](const SurfacePanel& panel) { panels[at++] = panel; });
  });
  return panels;
}

}  // namespace vps
