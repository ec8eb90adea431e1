#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "vps/field/brick_traits.hpp"
#include "vps/field/build_field.hpp"
#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

constexpr double kBrickVoxel_m = 1e-3;

// Unit sphere's points by the golden angle.
glm::dvec3 OnUnitSphere(int i, int n) {
  const double z = 1.0 - (2.0 * i + 1.0) / n;
  const double r = std::sqrt(1.0 - z * z);
  return {r * std::cos(2.39996 * i), r * std::sin(2.39996 * i), z};
}

// Words hold distances in steps of 1/256 voxel. On a flat face all are rounded alike, so that nothing averages out.
TEST(SurfaceErrors, OfFlatFacesAreRoundingAlone) {
  const auto in_the_middle = [](const glm::dvec3& size_m) {
    const DistanceField field = *BuildField(MakeBox(size_m), kBrickVoxel_m);
    return SurfaceErrorAt(field, glm::vec3((glm::dvec3(0.0, 0.0, 0.5 * size_m.z) - field.origin_m) / kBrickVoxel_m));
  };
  const glm::dvec3 whole_voxels(0.06, 0.06, 0.02);
  EXPECT_EQ(in_the_middle(whole_voxels), 0.0f);
  EXPECT_NEAR(in_the_middle(whole_voxels + glm::dvec3(0.0, 0.0, kBrickVoxel_m / 512.0)), 6.0f / 1024.0f, 1e-3f);
}

// The stored error is the root mean square error of SampleField, here at places other than those of the build; a little
// more where errors have one sign.
TEST(SurfaceErrors, EqualTheFieldsErrorAtTheSurface) {
  const TriangleMesh mesh = MakeSphere(0.02, 24);
  const DistanceField field = *BuildField(mesh, kBrickVoxel_m);
  double squares = 0.0;
  double stored = 0.0;
  std::size_t count = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b, c] = mesh.corners(t);
    const double area_m2 = 0.5 * glm::length(glm::cross(b - a, c - a));
    const int places = static_cast<int>(area_m2 / (0.1 * kBrickVoxel_m * kBrickVoxel_m));
    for (int i = 0; i < places; ++i) {
      const double u = std::sqrt((i + 0.5) / places);
      const double v = glm::fract(0.6180339887 * i);
      const glm::dvec3 p = a + u * ((1.0 - v) * (b - a) + v * (c - a));
      const glm::vec3 q((p - field.origin_m) / kBrickVoxel_m);
      squares += std::pow(static_cast<double>(SampleField(field, q).distance), 2);
      stored += std::pow(static_cast<double>(SurfaceErrorAt(field, q)), 2);
      ++count;
    }
  }
  EXPECT_GT(count, 10'000U);
  EXPECT_GT(std::sqrt(squares / static_cast<double>(count)), 0.002);
  EXPECT_GT(std::sqrt(stored / squares), 0.85);
  EXPECT_LT(std::sqrt(stored / squares), 1.3);
}

TEST(SurfaceErrors, AreContinuous) {
  const DistanceField field = *BuildField(MakeTorus(0.02, 0.007, 20, 10), kBrickVoxel_m);
  for (int i = 0; i < 200; ++i) {
    const glm::vec3 p = glm::vec3((0.02 * OnUnitSphere(i, 200) - field.origin_m) / kBrickVoxel_m);
    for (int k = 0; k < 64; ++k) {
      const glm::vec3 at = p + glm::vec3(0.25f * static_cast<float>(k), 0.0f, 0.0f);
      const float step = SurfaceErrorAt(field, at + glm::vec3(1e-3f, 0.0f, 0.0f)) - SurfaceErrorAt(field, at);
      EXPECT_LT(std::abs(step), 1e-3f * 255.0f * kErrorStep / 8.0f + 1e-6f);
    }
  }
}

}  // namespace
}  // namespace vps
