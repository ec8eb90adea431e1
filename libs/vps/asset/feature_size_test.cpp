#include "vps/asset/feature_size.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <random>

#include "vps/field/build_field.hpp"
#include "vps/testing/shapes.hpp"
#include "vps/voxmap/build_voxmap.hpp"

namespace vps {
namespace {

TriangleMesh Turned(TriangleMesh mesh, const glm::dquat& R, const glm::dvec3& by) {
  for (auto& p : mesh.vertices) p = R * p + by;
  return mesh;
}

TEST(MeasureFeatures, FindsTheWallOfABoxAndNoGap) {
  const FeatureSize size = MeasureFeatures(MakeBox({0.1, 0.05, 0.003}));
  EXPECT_NEAR(size.thickness_m, 0.003, 1e-9);
  EXPECT_TRUE(std::isinf(size.gap_m));
}

TEST(MeasureFeatures, FindsTheHoleAndTheWallBesideIt) {
  const FeatureSize size = MeasureFeatures(MakeBlockWithHole(0.05, 0.03, 0.01, 96));
  EXPECT_NEAR(size.gap_m, 0.02, 2e-4);
  EXPECT_NEAR(size.thickness_m, 0.015, 3e-4);
  EXPECT_NEAR(std::hypot(size.narrowest_m.x, size.narrowest_m.y), 0.0, 1e-3);
}

TEST(MeasureFeatures, FindsTheGapBetweenTwoPlates) {
  const TriangleMesh plate = MakeBox({0.1, 0.1, 0.01});
  const FeatureSize size = MeasureFeatures(Joined(plate, Turned(plate, glm::dquat(1, 0, 0, 0), {0.03, 0, 0.0104})));
  EXPECT_NEAR(size.gap_m, 0.0004, 1e-9);
  EXPECT_NEAR(size.thickness_m, 0.01, 1e-9);
  EXPECT_NEAR(size.narrowest_m.z, 0.0052, 1e-9);
}

// All triangles of the ball are about as far from its middle; the plate is looked for all the same.
TEST(MeasureFeatures, FindsAThinPlateBesideAFineBall) {
  const TriangleMesh ball = MakeSphere(0.03, 256);
  EXPECT_NEAR(MeasureFeatures(ball).thickness_m, 0.06, 6e-5);
  const TriangleMesh plate = Turned(MakeBox({0.05, 0.05, 0.002}), glm::dquat(1, 0, 0, 0), {0.1, 0.0, 0.0});
  EXPECT_NEAR(MeasureFeatures(Joined(ball, plate)).thickness_m, 0.002, 1e-9);
}

// A wall and a gap of the stated width, at random tilts and offsets: the middle has the right sign everywhere.
class FeatureLimitsTest : public testing::Test {
 protected:
  static constexpr double kVoxel_m = 0.001;

  // make(mesh, side) gives a function of a point: positive where the side (1 inside, -1 outside) shows.
  template <class Make>
  void Check(const FeatureLimits& limits, const Make& make) {
    std::mt19937_64 engine(11);
    const auto random = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53 * 2.0 - 1.0; };
    for (int pose = 0; pose < 7; ++pose) {
      glm::dquat R = glm::normalize(glm::dquat(random(), random(), random(), random()));
      if (pose == 0) R = glm::dquat(1, 0, 0, 0);
      const glm::dvec3 by = kVoxel_m * glm::dvec3(random(), random(), random());
      const TriangleMesh wall = Turned(MakeBox({0.02, 0.02, limits.thickness_m}), R, by);
      const auto shows_wall = make(wall, 1);
      const TriangleMesh plate = MakeBox({0.02, 0.02, 0.006});
      const glm::dvec3 apart(0, 0, 0.5 * (0.006 + limits.gap_m));
      const TriangleMesh gap = Joined(Turned(plate, R, by + R * apart), Turned(plate, R, by - R * apart));
      const auto shows_gap = make(gap, -1);
      for (int i = 0; i < 300; ++i) {
        const glm::dvec3 p = by + R * (0.006 * glm::dvec3(random(), random(), 0.0));
        ASSERT_GT(shows_wall(p), 0.0) << pose;
        ASSERT_GT(shows_gap(p), 0.0) << pose;
      }
    }
  }
};

TEST_F(FeatureLimitsTest, HoldForTheFieldOfFast) {
  Check(LimitsOf(Method::kFast, kVoxel_m), [](const TriangleMesh& mesh, int side) {
    return [field = *BuildField(mesh, kVoxel_m), side](const glm::dvec3& p) {
      return -side * SampleField(field, glm::vec3((p - field.origin_m) / field.voxel_size_m)).distance;
    };
  });
}

TEST_F(FeatureLimitsTest, HoldForTheVoxelsOfPaper) {
  FeatureLimits limits = LimitsOf(Method::kPaper, kVoxel_m);
  limits.thickness_m *= 1.0 + 1e-9;
  limits.gap_m *= 1.0 + 1e-9;
  Check(limits, [](const TriangleMesh& mesh, int side) {
    return [map = *BuildVoxmap(mesh, kVoxel_m), side](const glm::dvec3& p) {
      const glm::ivec3 c((p - map.origin_m) / map.voxel_size_m);
      return side * map.at(c.x, c.y, c.z);
    };
  });
}

}  // namespace
}  // namespace vps
