#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "core/parallel_for.hpp"
#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// A part of a triangle, small against the spacing of samples.
struct SurfacePanel {
  glm::dvec3 centroid_m{0.0};
  glm::dvec3 normal{0.0};  // unit, outwards
  double area_m2 = 0.0;
  double radius_m = 0.0;  // of its corners around the centroid
};

// The surface cut into panels whose longest side is at most `longest_m` (CutTriangle): areas and centroids are exact,
// so that sums over panels are. Triangles without area are left out. `begins`: of CountPanels with
// the same mesh and length.
std::vector<SurfacePanel> MakePanels(const TriangleMesh& mesh, double longest_m, std::span<const std::size_t> begins,
                                     core::ParallelFor* workers = nullptr);

// The number of the first panel of each block of triangles, and at last of all panels, without storing them.
std::vector<std::size_t> CountPanels(const TriangleMesh& mesh, double longest_m, core::ParallelFor* workers = nullptr);

}  // namespace vps
