#include "vps/sampling/surface_samples.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <vector>

#include "core/testing/backward_threads.hpp"
#include "vps/sampling/surface_panels.hpp"
#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

TEST(SurfaceSamples, AreasSumToTheSurface) {
  const auto samples = SampleSurface(MakeBox({0.1, 0.2, 0.3}), 2000);
  ASSERT_TRUE(samples);
  ASSERT_EQ(samples->points_m.size(), 2000U);
  double area = 0.0;
  for (const double a : samples->areas_m2) area += a;
  EXPECT_NEAR(area, 2.0 * (0.02 + 0.03 + 0.06), 1e-12);
}

TEST(SurfaceSamples, EveryFaceOfABoxKeepsItsArea) {
  const auto samples = SampleSurface(MakeBox({0.1, 0.2, 0.3}), 3000);
  std::map<int, double> faces;
  for (std::size_t i = 0; i < samples->points_m.size(); ++i) {
    const glm::dvec3 n = samples->inward_normals[i];
    faces[static_cast<int>(std::lround(n.x + 3.0 * n.y + 9.0 * n.z))] += samples->areas_m2[i];
  }
  ASSERT_EQ(faces.size(), 6U);
  for (const double sign : {-1.0, 1.0}) {
    EXPECT_NEAR(faces[static_cast<int>(sign)], 0.06, 2e-5);
    EXPECT_NEAR(faces[static_cast<int>(3 * sign)], 0.03, 2e-5);
    EXPECT_NEAR(faces[static_cast<int>(9 * sign)], 0.02, 2e-5);
  }
}

// The integral of x^2 over the mesh: for a triangle, area / 12 (sum of corners' squares + square of their sum).
TEST(SurfaceSamples, IntegralsDoNotDependOnTheirNumber) {
  const TriangleMesh sphere = MakeSphere(0.1, 96);
  double exact = 0.0;
  for (std::size_t t = 0; t < sphere.triangles.size(); ++t) {
    const auto [a, b, c] = sphere.corners(t);
    const double sum = a.x + b.x + c.x;
    exact += 0.5 * glm::length(glm::cross(b - a, c - a)) / 12.0 * (a.x * a.x + b.x * b.x + c.x * c.x + sum * sum);
  }
  for (const std::uint32_t count : {500U, 2000U, 8000U}) {
    const auto samples = SampleSurface(sphere, count);
    double sum = 0.0;
    for (std::size_t i = 0; i < samples->points_m.size(); ++i) {
      sum += samples->areas_m2[i] * samples->points_m[i].x * samples->points_m[i].x;
    }
    EXPECT_NEAR(sum / exact, 1.0, 4.0 / count) << count;
  }
}

// A corrugated plate under an even depth is pushed by its plan area, however few samples there are to a ridge.
TEST(SurfaceSamples, VectorAreasAreExact) {
  constexpr int kRidges = 40;
  TriangleMesh plate;
  for (int i = 0; i <= 2 * kRidges; ++i) {
    const double x = 0.5 * i / kRidges;
    const double z = i % 2 == 0 ? 0.0 : 0.5 / kRidges * std::tan(0.35);
    for (const double y : {0.0, 1.0}) plate.vertices.emplace_back(x, y, z);
    const auto at = static_cast<std::uint32_t>(2 * i);
    if (i == 0) continue;
    plate.triangles.push_back({at - 2, at, at - 1});
    plate.triangles.push_back({at, at + 1, at - 1});
  }
  for (const std::uint32_t count : {100U, 1000U}) {
    const auto samples = SampleSurface(plate, count);
    ASSERT_TRUE(samples);
    glm::dvec3 sum(0.0);
    for (std::size_t i = 0; i < count; ++i) sum += samples->areas_m2[i] * samples->inward_normals[i];
    EXPECT_LT(glm::length(sum - glm::dvec3(0.0, 0.0, -1.0)), 1e-9) << count;
  }
}

TEST(SurfaceSamples, NoWeightIsTwiceTheMean) {
  const auto samples = SampleSurface(MakeTorus(0.05, 0.02, 96, 48), 4000);
  double area = 0.0;
  double largest = 0.0;
  for (const double a : samples->areas_m2) {
    area += a;
    largest = std::max(largest, a);
  }
  EXPECT_LT(largest, 2.0 * area / 4000.0);
}

TEST(SurfaceSamples, AreasAndFirstMomentsAreExact) {
  const TriangleMesh mesh = MakeBlockWithHole(0.06, 0.04, 0.01, 48);
  double area = 0.0;
  glm::dvec3 moment(0.0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b, c] = mesh.corners(t);
    const double share = 0.5 * glm::length(glm::cross(b - a, c - a));
    area += share;
    moment += share * (a + b + c) / 3.0;
  }
  const auto samples = SampleSurface(mesh, 3000);
  for (std::size_t i = 0; i < samples->points_m.size(); ++i) {
    area -= samples->areas_m2[i];
    moment -= samples->areas_m2[i] * samples->points_m[i];
  }
  EXPECT_NEAR(area, 0.0, 1e-12);
  EXPECT_LT(glm::length(moment), 1e-13);
}

TEST(SurfaceSamples, AreTheSameBitForBitOnAnyNumberOfThreads) {
  const TriangleMesh mesh = MakeBlockWithHole(0.03, 0.02, 0.01005, 96);
  const auto serial = SampleSurface(mesh, 4096);
  ASSERT_TRUE(serial);
  for (const std::size_t threads : {1, 2, 5}) {
    core::test::BackwardThreads workers(threads);
    const auto samples = SampleSurface(mesh, 4096, {}, &workers);
    ASSERT_TRUE(samples);
    EXPECT_EQ(samples->points_m, serial->points_m) << threads;
    EXPECT_EQ(samples->inward_normals, serial->inward_normals) << threads;
    EXPECT_EQ(samples->areas_m2, serial->areas_m2) << threads;
  }
}

// The same cylinder in 64 and in 2,048 strips, each 1,300 times as long as wide. (These are narrower than a panel is
// long, so there are more; halving the strips' longest sides would make thousands for a point.)
TEST(SurfaceSamples, SliversTakeNoMorePanelsThanTheirArea) {
  const auto panels_of = [](std::uint32_t num_strips) {
    const TriangleMesh mesh = MakeCylinder(0.01, 0.04, num_strips);
    const double area_m2 = SurfaceArea_m2(mesh);
    const double longest_m = 0.6 * std::sqrt(area_m2 / 65536);
    const std::vector<SurfacePanel> panels = MakePanels(mesh, longest_m, CountPanels(mesh, longest_m));
    double sum_m2 = 0.0;
    double height = 0.0;
    for (const SurfacePanel& panel : panels) {
      sum_m2 += panel.area_m2;
      height += panel.area_m2 * panel.centroid_m.z;
      EXPECT_LE(panel.radius_m, longest_m);
    }
    EXPECT_NEAR(sum_m2, area_m2, 1e-9 * area_m2);
    const Box box = BoundingBox(mesh);
    EXPECT_NEAR(height / sum_m2, 0.5 * (box.lower.z + box.upper.z), 1e-9);
    return panels.size();
  };
  EXPECT_LT(panels_of(64), 30U * 65536U);
  EXPECT_LT(panels_of(2048), 55U * 65536U);
}

}  // namespace
}  // namespace vps
