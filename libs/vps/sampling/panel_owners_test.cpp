#include "vps/sampling/panel_owners.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "vps/sampling/surface_samples.hpp"
#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

// Against all points: none of the panel's face and plane is nearer.
void ExpectNearestOfTheirFace(const TriangleMesh& mesh, std::uint32_t num_points) {
  const auto samples = SampleSurface(mesh, num_points);
  ASSERT_TRUE(samples);
  Places places;
  places.spacing_m = std::sqrt(SurfaceArea_m2(mesh) / num_points);
  for (std::size_t i = 0; i < samples->points_m.size(); ++i) {
    places.points_m.push_back(samples->points_m[i]);
    places.normals.push_back(glm::normalize(-samples->inward_normals[i]));
  }
  const double longest_m = 0.6 * places.spacing_m;
  const std::vector<SurfacePanel> panels = MakePanels(mesh, longest_m, CountPanels(mesh, longest_m));
  const std::vector<std::uint32_t> owners = FindOwners(panels, places, nullptr);
  std::size_t num_compared = 0;
  for (std::size_t k = 0; k < panels.size(); ++k) {
    std::uint32_t nearest = kNobody;
    double least_m = 1.5 * places.spacing_m;
    for (std::uint32_t i = 0; i < places.points_m.size(); ++i) {
      const glm::dvec3 r = places.points_m[i] - panels[k].centroid_m;
      const double here_m = std::hypot(glm::length(r), 4.0 * glm::dot(r, panels[k].normal));
      if (glm::dot(places.normals[i], panels[k].normal) < 0.7071 || here_m >= least_m) continue;
      least_m = here_m;
      nearest = i;
    }
    if (nearest == kNobody) continue;
    ++num_compared;
    ASSERT_EQ(owners[k], nearest);
  }
  EXPECT_GT(num_compared, panels.size() * 9 / 10);
}

TEST(PanelOwners, AreTheNearestPointsOfTheirFace) {
  ExpectNearestOfTheirFace(MakeTorus(0.05, 0.02, 96, 48), 1500);
  ExpectNearestOfTheirFace(MakeBox({0.06, 0.04, 0.003}), 1500);
  ExpectNearestOfTheirFace(MakeCylinder(0.01, 0.04, 64), 1500);
}

// A cell that joined parallel faces of different height would have its centroid between them, where there is no
// surface: the point on the panel's own plane is taken, although the one of the other face is nearer; without one, what
// is nearest.
TEST(PanelOwners, DoNotJoinParallelFacesOfDifferentHeight) {
  const glm::dvec3 up(0.0, 0.0, 1.0);
  const std::vector<SurfacePanel> panels = {{glm::dvec3(0.0), up, 1e-8, 1e-4}};
  Places places{{{0.0, 0.0, -0.5e-3}, {1.2e-3, 0.0, 0.0}}, {up, up}, 1e-3};
  EXPECT_EQ(FindOwners(panels, places, nullptr)[0], 1U);
  places.points_m[1].x = 1.7e-3;
  EXPECT_EQ(FindOwners(panels, places, nullptr)[0], 0U);
}

}  // namespace
}  // namespace vps
