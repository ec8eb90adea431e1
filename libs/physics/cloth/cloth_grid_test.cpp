#include "physics/cloth/cloth_grid.hpp"

#include <gtest/gtest.h>

#include <functional>

namespace physics {
namespace {

constexpr double kBending_Nm = 0.003;

ClothParams Sheet() {
  ClothParams params;
  params.size_x_m = 0.3;
  params.size_y_m = 0.2;
  params.cells_x = 20;
  params.cells_y = 16;  // cells that are not square
  params.bending_stiffness_Nm = kBending_Nm;
  return params;
}

// Energy per area of a deformed sheet, over its middle half: bending terms are missing at the borders. Nodes on the rim
// of that half count by half.
double MiddleBending(const ClothParams& params, const std::function<double(double, double)>& z) {
  constexpr glm::dvec2 kHalf_m(0.075, 0.05);
  const auto grid = BuildClothGrid(params);
  EXPECT_TRUE(grid.has_value());
  double sum_J = 0.0;
  for (const ClothGrid::Bend& bend : grid->bends) {
    const bool is_line = bend.weight[3] == 0.0;
    double curl = 0.0;
    glm::dvec2 middle(0.0);
    for (std::size_t k = 0; k < 4; ++k) {
      const glm::dvec3& p = grid->p_W[bend.node[k]];
      curl += bend.weight[k] * z(p.x, p.y);
      if (!is_line || k == 1) middle += (is_line ? 1.0 : 0.25) * glm::dvec2(p);
    }
    const glm::dvec2 inside_m = kHalf_m - glm::abs(middle);
    double share = 1.0;
    for (const double margin_m : {inside_m.x, inside_m.y})
      share *= margin_m < -1e-6 ? 0.0 : margin_m < 1e-6 ? 0.5 : 1.0;
    sum_J += share * 0.5 * bend.stiffness_N_per_m * curl * curl;
  }
  return sum_J / (4.0 * kHalf_m.x * kHalf_m.y);
}

// Plate energy D/2 (kxx^2 + kyy^2 + 2 kxy^2) of the three shapes of constant curvature.
TEST(ClothGrid, BendingEnergyEqualsThatOfThePlate) {
  const double k = 0.7;
  const double half = 0.5 * kBending_Nm * k * k;
  EXPECT_NEAR(MiddleBending(Sheet(), [&](double x, double) { return 0.5 * k * x * x; }) / half, 1.0, 1e-9);
  EXPECT_NEAR(MiddleBending(Sheet(), [&](double, double y) { return 0.5 * k * y * y; }) / half, 1.0, 1e-9);
  EXPECT_NEAR(MiddleBending(Sheet(), [&](double x, double y) { return k * x * y; }) / (2.0 * half), 1.0, 1e-9);
}

// Energy density of a uniform strain, of the lattice and of plane stress with Poisson's ratio 1/3: equal, also with
// cells that are not square.
TEST(ClothGrid, StretchingEnergyEqualsThatOfTheSheet) {
  const ClothParams params = Sheet();
  const auto grid = BuildClothGrid(params);
  ASSERT_TRUE(grid.has_value());
  const double Y = params.stretch_stiffness_N_per_m;
  for (const glm::dvec3& strain :
       {glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1), glm::dvec3(1, -2, 3)}) {
    double sum_J = 0.0;
    for (const ClothGrid::Spring& spring : grid->springs) {
      const glm::dvec3 d = grid->p_W[spring.b] - grid->p_W[spring.a];
      const glm::dvec3 n = d / spring.rest_m;
      // xx, yy and xy of the strain: stretch of a line along n, to first order.
      const double stretch = spring.rest_m * (strain.x * n.x * n.x + strain.y * n.y * n.y + 2.0 * strain.z * n.x * n.y);
      sum_J += 0.5 * spring.stiffness_N_per_m * stretch * stretch;
    }
    const double expected =
        0.5 * (9.0 * Y / 8.0 * (strain.x * strain.x + strain.y * strain.y) + 2.0 * 3.0 * Y / 8.0 * strain.x * strain.y +
               4.0 * 3.0 * Y / 8.0 * strain.z * strain.z);
    EXPECT_NEAR(sum_J / (0.3 * 0.2) / expected, 1.0, 1e-12);
  }
}

TEST(ClothGrid, NodeMassesAddUpToTheMassOfTheSheet) {
  const auto grid = BuildClothGrid(Sheet());
  ASSERT_TRUE(grid.has_value());
  double sum_kg = 0.0;
  for (const double mass : grid->mass_kg) sum_kg += mass;
  EXPECT_NEAR(sum_kg, 0.5 * 0.3 * 0.2, 1e-12);
}

}  // namespace
}  // namespace physics
