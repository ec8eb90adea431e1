#include "vps/sampling/sample_tree.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

TEST(SampleTree, HoldsEveryPointOnceWithItsArea) {
  for (const std::uint32_t count : {1U, 15U, 16U, 17U, 257U, 5000U}) {
    const SurfaceSamples samples = *SampleSurface(MakeTorus(0.05, 0.02, 32, 16), count);
    const SampleTree tree = BuildSampleTree(samples);
    std::vector<std::array<float, 4>> expected, found;
    for (std::size_t i = 0; i < count; ++i) {
      const glm::vec3 p(samples.points_m[i]);
      expected.push_back({p.x, p.y, p.z, static_cast<float>(samples.areas_m2[i])});
    }
    for (const PointBlock& b : tree.points) {
      for (std::uint32_t k = 0; k < kBlock; ++k) {
        if (b.x[k] != SampleTree::kFarAway_m) found.push_back({b.x[k], b.y[k], b.z[k], b.area_m2[k]});
      }
    }
    std::sort(expected.begin(), expected.end());
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected) << count;
  }
}

TEST(SampleTree, SpheresHoldEverythingBelow) {
  const SampleTree tree = BuildSampleTree(*SampleSurface(MakeBlockWithHole(0.05, 0.05, 0.01, 32), 5000));
  ASSERT_EQ(tree.num_levels, 3U);  // 313 blocks, 20 spheres, 2 spheres
  for (std::uint32_t level = 0; level < tree.num_levels; ++level) {
    const std::uint32_t end =
        level + 1 < tree.num_levels ? tree.level_begin[level + 1] : static_cast<std::uint32_t>(tree.spheres.size());
    std::size_t run = 1;  // point blocks under a sphere
    for (std::uint32_t k = 0; k < level; ++k) run *= kBlock;
    for (std::uint32_t b = tree.level_begin[level]; b < end; ++b) {
      for (std::uint32_t lane = 0; lane < kBlock; ++lane) {
        const SphereBlock& sphere = tree.spheres[b];
        const glm::dvec3 centre(sphere.x[lane], sphere.y[lane], sphere.z[lane]);
        const std::size_t first = (std::size_t{b - tree.level_begin[level]} * kBlock + lane) * run;
        for (std::size_t p = first; p < std::min(first + run, tree.points.size()); ++p) {
          for (std::uint32_t k = 0; k < kBlock; ++k) {
            const PointBlock& point = tree.points[p];
            if (point.x[k] == SampleTree::kFarAway_m) continue;
            ASSERT_LE(glm::length(glm::dvec3(point.x[k], point.y[k], point.z[k]) - centre), sphere.r[lane]);
          }
        }
      }
    }
  }
}

TEST(SampleTree, EstimatesItsMemoryFromAbove) {
  for (const std::uint32_t num_points : {1000U, 40000U}) {
    const TriangleMesh mesh = MakeTorus(0.05, 0.02, 48, 24);
    const auto estimate = EstimateSampleTree(mesh, num_points);
    ASSERT_TRUE(estimate);
    const auto stored = static_cast<double>(BuildSampleTree(*SampleSurface(mesh, num_points)).num_bytes());
    EXPECT_GE(estimate->stored_bytes, stored) << num_points;
    EXPECT_LE(estimate->stored_bytes, 1.05 * stored + 4000.0) << num_points;
    EXPECT_GT(estimate->peak_bytes, estimate->stored_bytes);
  }
}

// A block of 16 points on a plane cannot be smaller than 16 shares of the area.
TEST(SampleTree, BlocksAreCompact) {
  const SampleTree tree = BuildSampleTree(*SampleSurface(MakeTorus(0.05, 0.02, 64, 32), 8000));
  const double ideal = std::sqrt(16.0 * tree.area_m2 / 8000.0 / 3.14159);
  double mean = 0.0;
  for (std::size_t b = 0; b < tree.points.size(); ++b) mean += tree.spheres[b / kBlock].r[b % kBlock];
  EXPECT_LT(mean / static_cast<double>(tree.points.size()), 1.6 * ideal);
}

}  // namespace
}  // namespace vps
