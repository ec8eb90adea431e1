#include "vps/oracle/exact_distance.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace vps::oracle {
namespace {

TriangleMesh UnitBox() {  // [-1, 1]^3
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) mesh.vertices.push_back({i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1});
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

double BoxDistance(const glm::dvec3& p) {
  const glm::dvec3 q = glm::abs(p) - 1.0;
  return glm::length(glm::max(q, 0.0)) + std::min(std::max(q.x, std::max(q.y, q.z)), 0.0);
}

TEST(ExactDistance, EqualsTheClosedFormOfABox) {
  const ExactDistance oracle(UnitBox());
  std::mt19937_64 rng(7);
  const auto coordinate = [&] { return -2.0 + 4.0 * static_cast<double>(rng() >> 11) * 0x1.0p-53; };
  for (int i = 0; i < 2000; ++i) {
    const glm::dvec3 p(coordinate(), coordinate(), coordinate());
    EXPECT_NEAR(oracle.SignedDistance(p), BoxDistance(p), 1e-14);
  }
}

TEST(ExactDistance, WindingNumberIsOneInsideAndZeroOutside) {
  const ExactDistance oracle(UnitBox());
  EXPECT_NEAR(oracle.WindingNumber({0.3, -0.2, 0.9}), 1.0, 1e-12);
  EXPECT_NEAR(oracle.WindingNumber({0.3, -0.2, 1.1}), 0.0, 1e-12);
}

TEST(ClosestPointOnTriangle, CoversFaceEdgesAndCorners) {
  const std::array<glm::dvec3, 3> t{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  EXPECT_EQ(ClosestPointOnTriangle({0.2, 0.3, 5}, t), glm::dvec3(0.2, 0.3, 0));
  EXPECT_EQ(ClosestPointOnTriangle({0.5, -2, 1}, t), glm::dvec3(0.5, 0, 0));
  EXPECT_EQ(ClosestPointOnTriangle({-1, -1, 0}, t), glm::dvec3(0, 0, 0));
  EXPECT_EQ(ClosestPointOnTriangle({3, -1, 0}, t), glm::dvec3(1, 0, 0));
}

}  // namespace
}  // namespace vps::oracle
