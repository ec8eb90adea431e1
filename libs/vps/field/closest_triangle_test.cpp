#include "vps/field/closest_triangle.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "vps/field/triangle_rows.hpp"
#include "vps/testing/case_random.hpp"

namespace vps {
namespace {

TriangleMesh Soup(int num_triangles, double half, double size, CaseRandom* random) {
  TriangleMesh mesh;
  for (int i = 0; i < num_triangles; ++i) {
    const glm::dvec3 middle = half * random->InCube();
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (int k = 0; k < 3; ++k) mesh.vertices.push_back(middle + size * random->InCube());
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

double LeastSquared(const TriangleField& field, const glm::dvec3& p) {
  double least = 1e300;
  for (std::uint32_t t = 0; t < field.num_triangles(); ++t) {
    least = std::min(least, field.Closest(t, p).squared_distance);
  }
  return least;
}

// From one triangle to several levels of boxes, from within and from far outside, where single precision is coarse.
TEST(ClosestTriangle, FromTheTreeEqualsExhaustiveSearch) {
  CaseRandom random(1);
  for (const int num_triangles : {1, 2, 8, 9, 64, 65, 700}) {
    const TriangleField field(Soup(num_triangles, 200.0, 20.0, &random));
    for (const double half : {250.0, 2e5}) {
      for (int i = 0; i < 200; ++i) {
        const glm::dvec3 p = half * random.InCube();
        std::uint32_t triangle = 0;
        const ClosestFeature closest = field.ClosestOfAll(p, &triangle);
        ASSERT_EQ(closest.squared_distance, LeastSquared(field, p)) << num_triangles << " " << i;
        EXPECT_EQ(closest.squared_distance, field.Closest(triangle, p).squared_distance);
        const double distance = std::sqrt(closest.squared_distance);
        std::size_t num_tests = 0;
        const auto within = field.ClosestWithin(p, 1.001 * distance, &num_tests);
        ASSERT_TRUE(within) << num_triangles << " " << i;
        EXPECT_EQ(within->squared_distance, closest.squared_distance);
        EXPECT_GT(num_tests, 0U);
        EXPECT_FALSE(field.ClosestWithin(p, 0.999 * distance, &num_tests));
      }
    }
  }
}

// The tangent bound never excludes a point's nearest triangle.
TEST(NearTriangles, IncludeTheNearestOfEveryPointAroundACell) {
  CaseRandom random(1);
  std::size_t count = 0;
  for (int round = 0; round < 200; ++round) {
    const TriangleField field(Soup(30, 6.0, 2.0, &random));
    std::vector<std::uint32_t> numbers(field.num_triangles());
    std::iota(numbers.begin(), numbers.end(), 0U);
    std::vector<RowTriangle> rows;
    for (const std::uint32_t t : numbers) {
      const auto& [a, b, c] = field.corners(t);
      rows.emplace_back(a, b, c);
    }
    const glm::vec3 centre(3.0f, 2.0f, 1.0f);
    const auto distance = static_cast<float>(std::sqrt(LeastSquared(field, centre)));
    PointRow offsets[kNearRows];
    for (PointRow& row : offsets) {
      for (int i = 0; i < kRow; ++i) {
        const glm::dvec3 offset = 0.5 * random.InCube();
        row.x[i] = static_cast<float>(offset.x);
        row.y[i] = static_cast<float>(offset.y);
        row.z[i] = static_cast<float>(offset.z);
      }
    }
    float reach[kRow];
    std::fill(std::begin(reach), std::end(reach), -1.0f);
    reach[3] = distance + 1.75f;  // twice the distance of a corner of the cell, and some rounding
    std::array<std::vector<NearTriangle>, kRow> near;
    FindNear(rows, TriangleBounds(rows), numbers, 2, 1, reach, &near);
    EXPECT_TRUE(near[2].empty());
    NearestOfPoints nearest;
    FindNearest(near[3], centre, offsets, &nearest);
    for (int i = 0; i < kNearRows * kRow; ++i) {
      const PointRow& row = offsets[i / kRow];
      const glm::dvec3 p = glm::dvec3(centre) + glm::dvec3(row.x[i % kRow], row.y[i % kRow], row.z[i % kRow]);
      const std::uint32_t found = near[3][nearest.triangle[i]].number;
      EXPECT_NEAR(std::sqrt(field.Closest(found, p).squared_distance), std::sqrt(LeastSquared(field, p)), 1e-4);
      ++count;
    }
  }
  EXPECT_EQ(count, 200U * kNearRows * kRow);
}

}  // namespace
}  // namespace vps
