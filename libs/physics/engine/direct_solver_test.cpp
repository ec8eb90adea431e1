#include "physics/engine/direct_solver.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace physics {
namespace {

double Uniform(std::mt19937_64* random) {
  return static_cast<double>((*random)() >> 11) * 0x1p-53;
}

TEST(DirectSolver, AnswerMeetsTheConditionsForRandomMatricesAndBounds) {
  std::mt19937_64 random(3);
  DirectSolver solver;
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 2 + trial % 30;
    std::vector<double> G(static_cast<std::size_t>(n * n));
    for (double& g : G) g = Uniform(&random) - 0.5;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        double a = i == j ? 1e-3 : 0.0;
        for (int k = 0; k < n; ++k)
          a += G[static_cast<std::size_t>(i * n + k)] * G[static_cast<std::size_t>(j * n + k)];
        solver.A(i, j) = a;
      }
      solver.b(i) = Uniform(&random) - 0.3;
      solver.bounds(i) = {0.0, i % 3 == 0 ? 0.2 : 1e30, DirectSolver::kNoNormal, 0.0};
      solver.lambda(i) = 0.0;
    }
    ASSERT_TRUE(solver.Solve(n)) << trial;
    for (int i = 0; i < n; ++i) {
      double excess = -solver.b(i);
      for (int j = 0; j < n; ++j) excess += solver.A(i, j) * solver.lambda(j);
      const double value = solver.lambda(i);
      EXPECT_GE(value, solver.bounds(i).lower - 1e-6);
      EXPECT_LE(value, solver.bounds(i).upper + 1e-6);
      const bool is_inside = value > 1e-6 && value < solver.bounds(i).upper - 1e-6;
      EXPECT_TRUE(!is_inside || std::abs(excess) <= 1e-7) << excess;
      EXPECT_TRUE(value > 1e-12 || excess >= -1e-7) << excess;
      EXPECT_TRUE(value < solver.bounds(i).upper || excess <= 1e-7) << excess;
    }
  }
}

TEST(DirectSolver, FrictionStopsAtTheConesEdge) {
  // One block, normal and friction uncoupled: pressed with 10, pushed with 2 or 5 at mu = 0.3.
  for (const double push : {2.0, 5.0}) {
    DirectSolver solver;
    solver.A(0, 0) = solver.A(1, 1) = 1.0;
    solver.A(0, 1) = solver.A(1, 0) = 0.0;
    solver.b(0) = 10.0;
    solver.b(1) = -push;
    solver.bounds(0) = {0.0, 1e30, DirectSolver::kNoNormal, 0.0};
    solver.bounds(1) = {0.0, 0.0, 0, 0.3};
    solver.lambda(0) = solver.lambda(1) = 0.0;
    ASSERT_TRUE(solver.Solve(2));
    EXPECT_NEAR(solver.lambda(0), 10.0, 1e-12);
    EXPECT_NEAR(solver.lambda(1), -std::min(push, 3.0), 1e-12);
  }
}

TEST(DirectSolver, SaysWhenThereIsNoAnswer) {
  DirectSolver solver;
  solver.A(0, 0) = -1.0;
  solver.b(0) = 1.0;
  solver.bounds(0) = {};
  solver.lambda(0) = 0.5;
  EXPECT_FALSE(solver.Solve(1));
  EXPECT_EQ(solver.lambda(0), 0.5);
}

}  // namespace
}  // namespace physics
