#include "physics/engine/direct_solver.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace physics {
namespace {

double Uniform(std::mt19937_64* random) {
  return static_cast<double>((*random)() >> 11) * 0x1p-53;
}

TEST(DirectSolver, SolutionMeetsTheComplementarityConditionsForRandomProblems) {
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

TEST(DirectSolver, FrictionIsLimitedByTheCone) {
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

// A block on `n` points, each with a normal and one friction row, pressed and pulled; the rows couple through the
// block.
TEST(DirectSolver, SlidingFrictionIsProportionalToTheNormalForceForRandomContacts) {
  std::mt19937_64 random(5);
  DirectSolver solver;
  int num_solved = 0;
  int num_sliding = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const int n = 2 + trial % 12;
    const int rows = 2 * n;
    std::vector<double> G(static_cast<std::size_t>(rows * rows));
    for (double& g : G) g = 0.3 * (Uniform(&random) - 0.5);
    for (int i = 0; i < rows; ++i) {
      G[static_cast<std::size_t>(i * rows + i)] += 1.0;
      for (int j = 0; j <= i; ++j) {
        double a = 0.0;
        for (int k = 0; k < rows; ++k) {
          a += G[static_cast<std::size_t>(i * rows + k)] * G[static_cast<std::size_t>(j * rows + k)];
        }
        solver.A(i, j) = a;
      }
    }
    for (int c = 0; c < n; ++c) {
      solver.b(c) = Uniform(&random) - 0.2;
      solver.b(n + c) = 0.6 * (Uniform(&random) - 0.5);
      solver.bounds(c) = {0.0, 1e30, DirectSolver::kNoNormal, 0.0};
      solver.bounds(n + c) = {0.0, 0.0, c, 0.3};
      solver.lambda(c) = solver.lambda(n + c) = 0.0;
    }
    if (!solver.Solve(rows)) continue;
    ++num_solved;
    const auto excess = [&](int i) {
      double sum = -solver.b(i);
      for (int j = 0; j < rows; ++j) sum += (j < i ? solver.A(i, j) : solver.A(j, i)) * solver.lambda(j);
      return sum;
    };
    for (int c = 0; c < n; ++c) {
      EXPECT_GE(solver.lambda(c), -1e-9);
      EXPECT_GE(excess(c), -1e-8);
      EXPECT_LT(std::abs(excess(c)) * solver.lambda(c), 1e-8);
      const double friction = solver.lambda(n + c);
      const double limit = 0.3 * solver.lambda(c);
      EXPECT_LE(std::abs(friction), limit + 1e-9);
      const double slip = excess(n + c);
      if (std::abs(friction) < limit - 1e-9) {
        EXPECT_LT(std::abs(slip), 1e-8) << "sticks";
      } else if (limit > 1e-9) {
        EXPECT_LE(slip * friction, 1e-8) << "against the sliding";
        ++num_sliding;
      }
    }
  }
  EXPECT_GE(num_solved, 199);
  EXPECT_GT(num_sliding, 100);
}

TEST(DirectSolver, ReportsWhenThereIsNoSolution) {
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
