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
  const std::vector<SurfacePanel> panels = MakePanels(mesh, 0.6 * places.spacing_m);
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

// Stairs whose treads are narrower than the spacing of samples: a cell that joined treads of different height would
// have its centroid off the surface, and with it the depth of all of its area.
TEST(PanelOwners, DoNotJoinParallelFacesOfDifferentHeight) {
  constexpr int kSteps = 40;
  constexpr double kTread_m = 0.5e-3;
  TriangleMesh stairs;
  for (int i = 0; i <= 2 * kSteps; ++i) {
    for (const double y : {0.0, 0.02}) stairs.vertices.emplace_back((i + 1) / 2 * kTread_m, y, i / 2 * kTread_m);
    if (i == 0) continue;
    const auto at = static_cast<std::uint32_t>(2 * i);
    stairs.triangles.push_back({at - 2, at, at - 1});
    stairs.triangles.push_back({at, at + 1, at - 1});
  }
  const auto samples = SampleSurface(stairs, 400);  // 1.4 mm apart
  ASSERT_TRUE(samples);
  for (const glm::dvec3& p : samples->points_m) {
    const double x = p.x / kTread_m;
    const double z = p.z / kTread_m;
    // Over one step the surface stays within half of its diagonal of the line x - z = 1/2.
    EXPECT_LT(std::abs(x - z - 0.5) / std::sqrt(2.0), 0.5 * std::sqrt(2.0)) << x << " " << z;
  }
}

}  // namespace
}  // namespace vps
