#include "vps/asset/list_structures.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "vps/asset/cooked_object.hpp"
#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

constexpr double kBallRadius_m = 0.02, kBallVoxel_m = 0.001;
constexpr std::uint32_t kPoints = 2000;

class ListStructures : public testing::TestWithParam<Method> {
 protected:
  const CookedObject cooked_ = std::move(*Cook(
      MakeSphere(kBallRadius_m, 48), {.voxel_size_m = kBallVoxel_m, .num_points = kPoints, .method = GetParam()}));
  const bool is_fast_ = GetParam() == Method::kFast;
  const std::vector<SurfacePoint> points_ = is_fast_ ? PointsOf(*cooked_.samples) : PointsOf(*cooked_.points);
};

TEST_P(ListStructures, PointsLieOnTheSurfaceAndFaceOutwards) {
  EXPECT_NEAR(static_cast<double>(points_.size()), kPoints, 0.1 * kPoints) << "fillers of blocks are left out";
  for (const SurfacePoint& point : points_) {
    EXPECT_NEAR(glm::length(point.p_m), kBallRadius_m, 0.2 * kBallVoxel_m) << "the mesh has facets";
    EXPECT_GT(glm::dot(point.outward, glm::normalize(point.p_m)), 0.9);
  }
}

TEST_P(ListStructures, EveryLevelsSpheresHoldAllPoints) {
  const auto levels = is_fast_ ? LevelsOf(*cooked_.samples) : LevelsOf(*cooked_.points);
  ASSERT_GE(levels.size(), 2u);
  std::size_t fewer = 0;
  for (const std::vector<TreeSphere>& level : levels) {
    EXPECT_GT(level.size(), fewer) << "the root is the first";
    fewer = level.size();
    for (const SurfacePoint& point : points_) {
      const auto holds = [&](const TreeSphere& sphere) {
        return glm::distance(sphere.centre_m, point.p_m) <= sphere.radius_m * (1.0 + 1e-5);
      };
      ASSERT_TRUE(std::any_of(level.begin(), level.end(), holds)) << level.size();
    }
  }
}

TEST_P(ListStructures, SurfaceVoxelsAreThoseThatHoldPointsOfTheSurface) {
  const std::vector<glm::vec3> voxels = is_fast_ ? SurfaceVoxelsOf(*cooked_.field) : SurfaceVoxelsOf(*cooked_.voxmap);
  const double half_diagonal_m = 0.5 * std::sqrt(3.0) * kBallVoxel_m;
  for (const glm::vec3& centre_m : voxels) {
    EXPECT_NEAR(glm::length(glm::dvec3(centre_m)), kBallRadius_m, 1.1 * half_diagonal_m);
  }
  std::size_t held = 0;
  for (const SurfacePoint& point : points_) {
    held += std::any_of(voxels.begin(), voxels.end(), [&](const glm::vec3& centre_m) {
      const glm::dvec3 off = glm::abs(point.p_m - glm::dvec3(centre_m));
      return std::max({off.x, off.y, off.z}) <= 0.52 * kBallVoxel_m;
    });
  }
  EXPECT_GE(held, points_.size() - points_.size() / 200) << "tangent planes may miss a corner";
}

INSTANTIATE_TEST_SUITE_P(Methods, ListStructures, testing::Values(Method::kPaper, Method::kFast),
                         [](const auto& method) { return method.param == Method::kFast ? "fast" : "paper"; });

}  // namespace
}  // namespace vps
