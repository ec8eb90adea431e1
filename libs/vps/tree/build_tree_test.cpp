#include "vps/tree/build_tree.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

double DistanceToCentre(const PointTree& tree, const Cluster& c, std::uint32_t point) {
  return glm::length(glm::dvec3(tree.x[point], tree.y[point], tree.z[point]) -
                     glm::dvec3(c.centre_m[0], c.centre_m[1], c.centre_m[2]));
}

TEST(PointTree, HoldsEveryPointOnceAndInsideAllSpheresAbove) {
  for (const std::uint32_t count : {1U, 2U, 5U, 17U, 1000U, 6000U}) {
    const PointTree tree = BuildTree(*BuildPointshell(MakeTorus(0.1, 0.04, 48, 24), count));
    ASSERT_EQ(tree.num_points, count);
    std::vector<int> seen(count, 0);
    // Walks down with the spheres of the ancestors.
    struct Item {
      std::uint32_t cluster;
      std::vector<std::uint32_t> ancestors;
    };
    std::vector<Item> stack{{0, {}}};
    while (!stack.empty()) {
      Item item = stack.back();
      stack.pop_back();
      const Cluster& c = tree.clusters[item.cluster];
      item.ancestors.push_back(item.cluster);
      ASSERT_GE(c.num_children, 1);
      ASSERT_LE(c.num_children, 4);
      for (std::uint32_t k = 0; k < c.num_children; ++k) {
        if (!c.is_leaf) {
          stack.push_back({c.first_child + k, item.ancestors});
          continue;
        }
        ++seen[c.first_child + k];
        for (const std::uint32_t a : item.ancestors) {
          EXPECT_LE(DistanceToCentre(tree, tree.clusters[a], c.first_child + k), tree.clusters[a].radius_m);
        }
      }
      EXPECT_LE(DistanceToCentre(tree, c, c.parent_point), c.radius_m);
    }
    for (const int n : seen) EXPECT_EQ(n, 1);
    EXPECT_EQ(tree.clusters[0].num_points, count);
  }
}

TEST(PointTree, MostClustersHoldFour) {
  const PointTree tree = BuildTree(*BuildPointshell(MakeTorus(0.1, 0.04, 48, 24), 6000));
  std::size_t full = 0;
  for (const Cluster& c : tree.clusters) full += c.num_children == 4 ? 1 : 0;
  EXPECT_GT(static_cast<double>(full), 0.9 * static_cast<double>(tree.clusters.size()));
}

TEST(SmallestSphere, OfKnownSetsIsExact) {
  // Corners of a cube (cospherical), a line, and a cloud inside a sphere of four of its own points.
  const float cx[] = {0, 1, 0, 1, 0, 1, 0, 1}, cy[] = {0, 0, 1, 1, 0, 0, 1, 1}, cz[] = {0, 0, 0, 0, 1, 1, 1, 1};
  EXPECT_NEAR(SmallestSphere(cx, cy, cz, 8).radius, std::sqrt(0.75), 1e-9);
  const float lx[] = {0, 1, 2, 3}, zero[] = {0, 0, 0, 0};
  EXPECT_NEAR(SmallestSphere(lx, zero, zero, 4).radius, 1.5, 1e-9);
  const float h = std::sqrt(0.75f);
  std::vector<float> x = {1, -0.5f, -0.5f, 0}, y = {0, h, -h, 0}, z = {0, 0, 0, 1};
  std::mt19937_64 random(5);
  for (int i = 0; i < 1000; ++i) {
    const auto u = [&] { return static_cast<float>(static_cast<double>(random() >> 11) * 0x1p-53 - 0.5); };
    x.push_back(u());
    y.push_back(u());
    z.push_back(0.5f + 0.5f * u());
  }
  const Sphere s = SmallestSphere(x.data(), y.data(), z.data(), x.size());
  EXPECT_NEAR(s.radius, 1.0, 1e-6);
  EXPECT_NEAR(glm::length(s.centre), 0.0, 1e-6);
}

}  // namespace
}  // namespace vps
