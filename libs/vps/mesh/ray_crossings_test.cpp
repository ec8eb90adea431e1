#include "vps/mesh/ray_crossings.hpp"

#include <gtest/gtest.h>

#include <random>

#include "vps/mesh/winding_number.hpp"
#include "vps/testing/part_shapes.hpp"
#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

// A closed mesh as CountRayCrossings takes it, with the sum of solid angles as the other way to find the number.
struct Surface {
  explicit Surface(const TriangleMesh& mesh) : tree(BuildBoxTree(mesh)) {
    for (const std::uint32_t t : tree.order) triangles.push_back(mesh.corners(t));
  }
  [[nodiscard]] double SumOfAngles(const glm::dvec3& p) const {
    double sum = 0.0;
    for (const auto& triangle : triangles) sum += WindingOfTriangle(triangle, p);
    return sum;
  }
  BoxTree tree;
  std::vector<std::array<glm::dvec3, 3>> triangles;
};

TEST(CountRayCrossings, IsTheSumOfSolidAngles) {
  const TriangleMesh parts[] = {
      MakeBox({0.06, 0.04, 0.03}), MakeTorus(0.04, 0.015, 24, 12), MakeCylinder(0.03, 0.05, 64),
      // Twice inside where two parts of one mesh overlap, and a part turned inside out.
      Joined(MakeBox({0.06, 0.04, 0.03}), MakeSphere(0.02, 16), {0.02, 0.01, 0.01}),
      MakeThreadedRod({.radius_m = 0.03, .depth_m = 0.004, .pitch_m = 0.01, .num_turns = 4, .num_segments = 24})};
  std::mt19937_64 engine(7);
  const auto random = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53 * 2.0 - 1.0; };
  int num_inside = 0;
  for (const TriangleMesh& mesh : parts) {
    const Surface surface(mesh);
    for (int i = 0; i < 1000; ++i) {
      const glm::dvec3 p = 0.05 * glm::dvec3(random(), random(), random());
      const auto count = CountRayCrossings(surface.tree, surface.triangles, p);
      ASSERT_TRUE(count);
      ASSERT_NEAR(*count, surface.SumOfAngles(p), 1e-6) << p.x << " " << p.y << " " << p.z;
      num_inside += *count > 0 ? 1 : 0;
    }
  }
  EXPECT_GT(num_inside, 500);
}

// Just beside each triangle, as FindTrustedNormals asks.
TEST(CountRayCrossings, DiffersByOneAcrossATriangle) {
  const TriangleMesh mesh = SplitTriangles(MakeBevelledBlock({0.05, 0.04, 0.03}, 0.004), 0.01);  // slivers
  const Surface surface(mesh);
  for (const auto& [a, b, c] : surface.triangles) {
    const glm::dvec3 off = 1e-7 * glm::normalize(glm::cross(b - a, c - a));
    const glm::dvec3 middle = (a + b + c) / 3.0;
    EXPECT_EQ(CountRayCrossings(surface.tree, surface.triangles, middle + off), 0);
    EXPECT_EQ(CountRayCrossings(surface.tree, surface.triangles, middle - off), 1);
  }
}

TEST(CountRayCrossings, IsInDoubtOnTheSurfaceOnly) {
  const Surface surface(MakeBox({2, 2, 2}));
  EXPECT_FALSE(CountRayCrossings(surface.tree, surface.triangles, {1.0, 0.3, 0.2}));
  EXPECT_EQ(CountRayCrossings(surface.tree, surface.triangles, {0, 0, 0}), 1);  // rays to edges and corners apart
  EXPECT_EQ(CountRayCrossings(surface.tree, surface.triangles, {3, 3, 3}), 0);
}

}  // namespace
}  // namespace vps
