#include "vps/pointshell/pointshell.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

TEST(Pointshell, HasTheRequestedNumberOfPointsOnTheSurfaceWithInwardNormals) {
  const auto shell = BuildPointshell(MakeSphere(0.05, 64), 5000);
  ASSERT_TRUE(shell.has_value());
  ASSERT_EQ(shell->points_m.size(), 5000U);
  for (std::size_t i = 0; i < shell->points_m.size(); ++i) {
    EXPECT_NEAR(glm::length(shell->points_m[i]), 0.05, 1.3e-4);  // facets lie inside the sphere
    EXPECT_NEAR(glm::length(shell->inward_normals[i]), 1.0, 1e-12);
    EXPECT_LT(glm::dot(shell->inward_normals[i], shell->points_m[i]), 0.0);
  }
}

TEST(Pointshell, IsUniformByArea) {
  // A box of unequal faces: points per face follow the areas.
  const auto shell = *BuildPointshell(MakeBox({0.1, 0.05, 0.02}), 8000);
  const double total = 2 * (0.1 * 0.05 + 0.1 * 0.02 + 0.05 * 0.02);
  const double areas[3] = {0.05 * 0.02, 0.1 * 0.02, 0.1 * 0.05};
  int counts[3] = {0, 0, 0};
  for (const auto& n : shell.inward_normals) {
    for (int k = 0; k < 3; ++k) counts[k] += std::abs(n[k]) > 0.9 ? 1 : 0;
  }
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(counts[k], 8000 * 2 * areas[k] / total, 0.06 * 8000 * 2 * areas[k] / total);
}

TEST(Pointshell, KeepsItsPointsApart) {
  // Random points of this density come arbitrarily close; blue noise keeps more than half the packing distance.
  const auto shell = *BuildPointshell(MakeTorus(0.05, 0.02, 64, 32), 2000);
  const double area = 4 * 3.14159265 * 3.14159265 * 0.05 * 0.02;
  const double packing = std::sqrt(2 * area / (std::sqrt(3.0) * 2000));
  double nearest = 1.0;
  for (std::size_t i = 0; i < 2000; ++i) {
    for (std::size_t j = 0; j < i; ++j) nearest = std::min(nearest, glm::length(shell.points_m[i] - shell.points_m[j]));
  }
  EXPECT_GT(nearest, 0.5 * packing);
}

TEST(Pointshell, KeepsBothSidesOfAThinPlate) {
  const auto shell = *BuildPointshell(MakeBox({0.1, 0.1, 0.0001}), 4000);
  int up = 0;
  int down = 0;
  for (const auto& n : shell.inward_normals) {
    up += n.z > 0.9 ? 1 : 0;
    down += n.z < -0.9 ? 1 : 0;
  }
  EXPECT_NEAR(up, down, 100);
}

TEST(Pointshell, IsTheSameEveryTime) {
  const auto mesh = MakeTorus(0.05, 0.02, 64, 32);
  EXPECT_EQ(BuildPointshell(mesh, 1000)->points_m, BuildPointshell(mesh, 1000)->points_m);
}

TEST(Pointshell, RefusesNothingToSample) {
  EXPECT_FALSE(BuildPointshell({}, 100).has_value());
  EXPECT_FALSE(BuildPointshell(MakeBox({1, 1, 1}), 0).has_value());
}

}  // namespace
}  // namespace vps
