#include "vps/mesh/thicken_sheet.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "vps/mesh/check_mesh.hpp"
#include "vps/mesh/mass_properties.hpp"
#include "vps/oracle/mesh_distance.hpp"
#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

// Two squares that share an edge, folded there.
TriangleMesh Fold(double side_m, double angle_rad) {
  const glm::dvec3 up = side_m * glm::dvec3(std::cos(angle_rad), 0, std::sin(angle_rad));
  const glm::dvec3 y(0, side_m, 0);
  const glm::dvec3 left(-side_m, 0, 0);
  return {{left, {0, 0, 0}, y, left + y, up, up + y}, {{0, 1, 2}, {0, 2, 3}, {1, 4, 5}, {1, 5, 2}}};
}

TEST(ThickenSheet, MakesAPlateASlab) {
  const TriangleMesh slab = ThickenSheet(Fold(0.1, 0.0), 0.004);
  EXPECT_EQ(CountOpenEdges(slab), 0U);
  const auto mass = ComputeMassProperties(slab, 1.0);
  ASSERT_TRUE(mass) << mass.error().detail;
  EXPECT_NEAR(mass->volume_m3, 0.2 * 0.1 * 0.004, 1e-15);
}

TEST(ThickenSheet, KeepsTheThicknessOfBothWingsOfAFold) {
  for (const double angle : {0.5, 1.2, std::numbers::pi / 2, 2.0}) {
    const TriangleMesh solid = ThickenSheet(Fold(0.1, angle), 0.004);
    const oracle::MeshDistance distance(solid);
    for (const double s : {0.02, 0.05, 0.08}) {
      const glm::dvec3 on_wing(s * std::cos(angle), 0.05, s * std::sin(angle));
      EXPECT_NEAR(distance.SignedDistance(on_wing), -0.002, 1e-9) << angle;
      EXPECT_NEAR(distance.SignedDistance({-s, 0.05, 0}), -0.002, 1e-9) << angle;
    }
  }
}

TEST(ThickenSheet, StaysHalfAThicknessAroundACurvedSheet) {
  TriangleMesh bowl = MakeSphere(0.05, 96);
  std::erase_if(bowl.triangles, [&](const auto& t) {
    return bowl.vertices[t[0]].z + bowl.vertices[t[1]].z + bowl.vertices[t[2]].z > 0.0;
  });
  const auto sheet = CheckMesh(bowl, true);
  ASSERT_TRUE(sheet) << sheet.error().detail;
  const TriangleMesh solid = ThickenSheet(sheet->mesh, 0.003);
  EXPECT_EQ(CountOpenEdges(solid), 0U);
  const oracle::MeshDistance distance(solid);
  const oracle::MeshDistance to_sheet(sheet->mesh, oracle::MeshDistance::Sides::kSheet);
  std::mt19937_64 engine(3);
  for (int i = 0; i < 2000; ++i) {
    const auto random = [&] { return static_cast<double>(engine() >> 11) * 0x1p-53 * 2.0 - 1.0; };
    const glm::dvec3 p = 0.06 * glm::dvec3(random(), random(), random());
    if (p.z > -0.01) continue;  // the rim is flat where the distance to the sheet is round
    ASSERT_NEAR(distance.SignedDistance(p), to_sheet.SignedDistance(p) - 0.0015, 2e-5);
  }
}

TEST(ThickenSheet, ClosesSheetsThatCannotBeOriented) {
  // Three wings on one edge.
  TriangleMesh wings{{{0, 0, 0}, {0, 1, 0}, {1, 0.5, 0}, {-1, 0.5, 0.5}, {-1, 0.5, -0.5}},
                     {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}}};
  const auto sheet = CheckMesh(wings, true);
  ASSERT_TRUE(sheet);
  const TriangleMesh solid = ThickenSheet(sheet->mesh, 0.05);
  EXPECT_EQ(CountOpenEdges(solid), 0U);
  const oracle::MeshDistance distance(solid);
  for (std::size_t t = 0; t < 3; ++t) {
    const auto [a, b, c] = wings.corners(t);
    EXPECT_TRUE(distance.IsInside((a + b + c) / 3.0));
  }
}

}  // namespace
}  // namespace vps
