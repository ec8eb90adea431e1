#pragma once

#include <vector>

#include "core/parallel_for.hpp"
#include "vps/sampling/sample_spacing.hpp"

namespace vps {

// A piece of a triangle, small against the spacing of samples there.
struct SurfacePanel {
  glm::dvec3 centroid_m{0.0};
  glm::dvec3 normal{0.0};  // unit, outwards
  double area_m2 = 0.0;
  double radius_m = 0.0;   // of its corners around the centroid
  double spacing_m = 0.0;  // of samples
};

// The surface cut into panels whose longest side is at most `size` of the samples' spacing, by halving the longest side
// (a sliver is cut across first): areas and centroids are exact, so that sums over panels are.
// Twenty to a sample, enough for areas and centroids: not derived.
constexpr double kPanelSize = 0.6;
std::vector<SurfacePanel> MakePanels(const TriangleMesh& mesh, const SampleSpacing& spacing, double size);

// The same in two steps, each on all workers: where the panels of each block of triangles begin, and where the last
// ones end, which is their number; then the panels.
std::vector<std::size_t> CountPanels(const TriangleMesh& mesh, const SampleSpacing& spacing, double size,
                                     core::ParallelFor* workers = nullptr);
std::vector<SurfacePanel> MakePanels(const TriangleMesh& mesh, const SampleSpacing& spacing, double size,
                                     const std::vector<std::size_t>& begins, core::ParallelFor* workers = nullptr);

}  // namespace vps
