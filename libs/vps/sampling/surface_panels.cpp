#include "vps/sampling/surface_panels.hpp"

#include <algorithm>

namespace vps {
namespace {

void Divide(const std::array<glm::dvec3, 3>& corners, const glm::dvec3& normal, const SampleSpacing& spacing,
            const SampleSpacing::Nearby& nearby, std::vector<SurfacePanel>* panels) {
  const auto& [a, b, c] = corners;
  const glm::dvec3 centroid = (a + b + c) / 3.0;
  const double radius = std::max({glm::length(a - centroid), glm::length(b - centroid), glm::length(c - centroid)});
  const double sides[3] = {glm::length(b - a), glm::length(c - b), glm::length(a - c)};
  const int k = static_cast<int>(std::max_element(sides, sides + 3) - sides);
  const double least_spacing = spacing.At(centroid, nearby, radius);
  if (sides[k] <= kPanelPerSpacing * least_spacing) {
    panels->push_back(
        {centroid, normal, 0.5 * glm::length(glm::cross(b - a, c - a)), radius, spacing.At(centroid, nearby)});
    return;
  }
  const glm::dvec3 from = corners[k];
  const glm::dvec3 to = corners[(k + 1) % 3];
  const glm::dvec3 opposite = corners[(k + 2) % 3];
  const glm::dvec3 middle = 0.5 * (from + to);
  const bool is_empty = nearby.segments.empty() && nearby.corners.empty();
  const SampleSpacing::Nearby narrow = is_empty ? nearby : spacing.Narrow(nearby, centroid, radius);
  Divide({from, middle, opposite}, normal, spacing, narrow, panels);
  Divide({middle, to, opposite}, normal, spacing, narrow, panels);
}

}  // namespace

std::vector<SurfacePanel> MakePanels(const TriangleMesh& mesh, const SampleSpacing& spacing) {
  std::vector<SurfacePanel> panels;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto corners = mesh.corners(t);
    const auto& [a, b, c] = corners;
    const glm::dvec3 n = glm::cross(b - a, c - a);
    const double length = glm::length(n);
    if (!(length > 0.0)) continue;
    const Box box{glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c))};
    Divide(corners, n / length, spacing, spacing.Around(box), &panels);
  }
  return panels;
}

}  // namespace vps
