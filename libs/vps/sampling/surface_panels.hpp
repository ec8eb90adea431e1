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
constexpr double kPanelSize = 0.6;
// Where a sample's finer points are made of them too: some sixty for the sixteen of each.
constexpr double kFinePanelSize = 0.35;
std::vector<SurfacePanel> MakePanels(const TriangleMesh& mesh, const SampleSpacing& spacing, double size);
// How many, without memory for them.
std::size_t CountPanels(const TriangleMesh& mesh, const SampleSpacing& spacing, double size);

}  // namespace vps
