#pragma once

#include <vector>

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

// Sixty to a sample, where its sixteen finer points are made of them too (decision 9, "of finer panels").
constexpr double kFinePanelSize = 0.35;
std::vector<SurfacePanel> MakePanels(const TriangleMesh& mesh, const SampleSpacing& spacing, double size);
// The number of MakePanels' panels, without storing them.
std::size_t CountPanels(const TriangleMesh& mesh, const SampleSpacing& spacing, double size);

}  // namespace vps
