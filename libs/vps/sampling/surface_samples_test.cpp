#include "vps/sampling/surface_samples.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "vps/mesh/shapes.hpp"

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

// The integral of x^2 over a sphere is 4/3 pi r^4: the same for few points and for many.
TEST(SurfaceSamples, IntegralsDoNotDependOnTheirNumber) {
  const TriangleMesh sphere = MakeSphere(0.1, 96);
  for (const std::uint32_t count : {500U, 2000U, 8000U}) {
    const auto samples = SampleSurface(sphere, count);
    double sum = 0.0;
    glm::dvec3 vector(0.0);
    for (std::size_t i = 0; i < samples->points_m.size(); ++i) {
      sum += samples->areas_m2[i] * samples->points_m[i].x * samples->points_m[i].x;
      vector += samples->areas_m2[i] * samples->inward_normals[i];
    }
    EXPECT_NEAR(sum / (4.0 / 3.0 * M_PI * 1e-4), 1.0, 0.002 + 4.0 / count) << count;
    EXPECT_LT(glm::length(vector), (0.0005 + 1.5 / count) * 4.0 * M_PI * 0.01)
        << count;  // normals of a closed surface cancel
  }
}

TEST(SurfaceSamples, NoPointStandsForFarMoreThanItsShare) {
  const auto samples = SampleSurface(MakeTorus(0.05, 0.02, 96, 48), 4000);
  double area = 0.0;
  double largest = 0.0;
  for (const double a : samples->areas_m2) {
    area += a;
    largest = std::max(largest, a);
  }
  EXPECT_LT(largest, 2.0 * area / 4000.0);
}

}  // namespace
}  // namespace vps
