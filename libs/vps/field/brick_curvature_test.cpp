#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "vps/field/brick_traits.hpp"
#include "vps/field/build_field.hpp"
#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

// Calls visit(middle of the brick in the mesh frame, its curvature in 1 / m) for every brick.
void ForBricks(const DistanceField& field, const std::function<void(const glm::dvec3&, double)>& visit) {
  const glm::ivec3 n = glm::ivec3(field.nx, field.ny, field.nz) / DistanceField::kBrick;
  for (int z = 0; z < n.z; ++z) {
    for (int y = 0; y < n.y; ++y) {
      for (int x = 0; x < n.x; ++x) {
        const auto at = static_cast<std::size_t>((z * n.y + y) * n.x + x);
        const glm::dvec3 middle = field.origin_m + (glm::dvec3(x, y, z) + 0.5) * 8.0 * field.voxel_size_m;
        visit(middle,
              static_cast<double>(field.curvatures[at]) * static_cast<double>(kCurvatureStep) / field.voxel_size_m);
      }
    }
  }
}

TEST(SurfaceCurvature, OfABallIsTwoOverItsRadius) {
  const double R = 0.02;
  int count = 0;
  ForBricks(*BuildField(MakeSphere(R, 128), 0.0005), [&](const glm::dvec3& p, double curvature) {
    if (std::abs(glm::length(p) - R) > 0.002) return;
    EXPECT_NEAR(curvature * R, 2.0, 0.1) << p.x << " " << p.y << " " << p.z;
    ++count;
  });
  EXPECT_GT(count, 100);
}

TEST(SurfaceCurvature, OfAHoleIsNegativeAndItsRimDoesNotCount) {
  const double R = 0.01;
  int count = 0;
  ForBricks(*BuildField(MakeBlockWithHole(0.06, 0.04, R, 128), 0.00025), [&](const glm::dvec3& p, double curvature) {
    if (std::abs(std::hypot(p.x, p.y) - R) > 0.001 || std::abs(p.z) > 0.015) return;
    EXPECT_NEAR(curvature * R, -1.0, 0.05) << p.x << " " << p.y << " " << p.z;
    ++count;
  });
  EXPECT_GT(count, 100);
}

TEST(SurfaceCurvature, OfABoxIsZero) {
  ForBricks(*BuildField(MakeBox({0.02, 0.03, 0.04}), 0.0005),
            [](const glm::dvec3&, double curvature) { EXPECT_EQ(curvature, 0.0); });
}

TEST(SurfaceCurvature, AnOpenBorderDoesNotCount) {
  TriangleMesh quad;
  quad.vertices = {{0.0, 0.0, 0.0}, {0.02, 0.0, 0.0}, {0.02, 0.02, 0.001}, {0.0, 0.02, 0.0}};
  quad.triangles = {{0, 1, 2}};
  ForBricks(*BuildField(quad, 0.0005), [](const glm::dvec3&, double curvature) { EXPECT_EQ(curvature, 0.0); });
}

}  // namespace
}  // namespace vps
