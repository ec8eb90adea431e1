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

// The same in two steps, each on all workers, so that memory can be refused before it is taken: the panels are counted,
// and then made. What fits is kept of the first step.
struct PanelCount {
  std::vector<std::size_t> begins;              // of the panels of each block of triangles; at last, of all
  std::vector<std::vector<SurfacePanel>> kept;  // of each block; empty: to be made anew
};
PanelCount CountPanels(const TriangleMesh& mesh, const SampleSpacing& spacing, double size, std::size_t most_kept = 0,
                       core::ParallelFor* workers = nullptr);
std::vector<SurfacePanel> MakePanels(const TriangleMesh& mesh, const SampleSpacing& spacing, double size,
                                     PanelCount count, core::ParallelFor* workers = nullptr);

}  // namespace vps
