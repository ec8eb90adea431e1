#include "vps/sampling/panel_owners.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "vps/sampling/surface_samples.hpp"
#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

// Against all points: the nearest within 45 degrees, wherever it is so near that no other could be meant.
void ExpectNearestOfTheirFace(const TriangleMesh& mesh, std::uint32_t num_points) {
  const auto samples = SampleSurface(mesh, num_points);
  ASSERT_TRUE(samples);
  double area_m2 = 0.0;
  for (const double a : samples->areas_m2) area_m2 += a;
  const std::vector<SurfacePanel> panels = MakePanels(mesh, SampleSpacing(mesh, area_m2, num_points), kPanelSize);
  Places places;
  for (std::size_t i = 0; i < samples->points_m.size(); ++i) {
    places.points_m.push_back(samples->points_m[i]);
    places.normals.push_back(glm::normalize(-samples->inward_normals[i]));
    places.spacings_m.push_back(std::sqrt(samples->areas_m2[i]));
  }
  const std::vector<std::uint32_t> owners = FindOwners(panels, places, nullptr);
  std::size_t num_compared = 0;
  for (std::size_t k = 0; k < panels.size(); ++k) {
    std::uint32_t nearest = kNobody;
    double least_m = 0.7 * panels[k].spacing_m;
    for (std::uint32_t i = 0; i < places.points_m.size(); ++i) {
      const double ratio = places.spacings_m[i] / panels[k].spacing_m;
      if (ratio < 0.4 || ratio > 2.0) continue;
      if (glm::dot(places.normals[i], panels[k].normal) < 0.7071) continue;
      const double distance_m = glm::length(places.points_m[i] - panels[k].centroid_m);
      if (distance_m >= least_m) continue;
      least_m = distance_m;
      nearest = i;
    }
    if (nearest == kNobody) continue;
    ++num_compared;
    if (owners[k] == nearest) continue;
    // Points of other spacings may be nearer.
    ASSERT_NE(owners[k], kNobody);
    EXPECT_LT(glm::length(places.points_m[owners[k]] - panels[k].centroid_m), least_m) << k;
    EXPECT_GE(glm::dot(places.normals[owners[k]], panels[k].normal), 0.7071);
  }
  EXPECT_GT(num_compared, panels.size() * 8 / 10);
}

TEST(PanelOwners, AreTheNearestPointsOfTheirFace) {
  ExpectNearestOfTheirFace(MakeTorus(0.05, 0.02, 96, 48), 1500);
  ExpectNearestOfTheirFace(MakeBox({0.06, 0.04, 0.003}), 1500);
  ExpectNearestOfTheirFace(MakeCylinder(0.01, 0.04, 64), 1500);
}

// Whether all panels are kept of counting them, some or none.
TEST(MakePanels, AreTheSameHoweverManyWereKept) {
  const TriangleMesh mesh = MakeCylinder(0.02, 0.03, 64);
  const SampleSpacing spacing(mesh, SurfaceArea_m2(mesh), 1000);
  const std::vector<SurfacePanel> expected = MakePanels(mesh, spacing, kPanelSize);
  ASSERT_GT(expected.size(), 10'000U);
  for (const std::size_t most_kept : {std::size_t{5000}, std::size_t{1'000'000}}) {
    PanelCount count = CountPanels(mesh, spacing, kPanelSize, most_kept);
    std::size_t num_kept = 0;
    for (const auto& block : count.kept) num_kept += block.size();
    EXPECT_EQ(num_kept == expected.size(), most_kept > expected.size());
    EXPECT_GT(num_kept, 0U);
    const std::vector<SurfacePanel> panels = MakePanels(mesh, spacing, kPanelSize, std::move(count));
    ASSERT_EQ(panels.size(), expected.size());
    for (std::size_t i = 0; i < panels.size(); ++i) {
      ASSERT_EQ(panels[i].centroid_m, expected[i].centroid_m);
      ASSERT_EQ(panels[i].spacing_m, expected[i].spacing_m);
    }
  }
}

}  // namespace
}  // namespace vps
