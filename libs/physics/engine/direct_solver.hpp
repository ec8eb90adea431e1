#pragma once

#include <cstdint>
#include <vector>

namespace physics {

// Solves A lambda = b within bounds, a mixed linear complementarity problem: for each row either lo < lambda < hi and
// A lambda - b = 0, or lambda = lo and A lambda - b >= 0, or lambda = hi and A lambda - b <= 0. Friction rows have the
// bounds -+ friction * lambda of their normal row. A is symmetric positive definite (compliance on its diagonal).
//
// Block principal pivoting [Judice and Pires 1994]: guess which rows are at a bound, solve for the others by Cholesky's
// factorisation, change the rows that violate their conditions, repeat. A sliding friction row is +-friction times its
// normal's lambda, which is inserted into the equations (then not symmetric, solved by elimination). Convergence is not
// guaranteed: after 30 iterations Solve returns false and leaves lambda unchanged.
class DirectSolver {
 public:
  static constexpr int kMaxRows = 128;  // 40 contacts with friction; chosen: a solve costs n^3 / 6 operations
  static constexpr int kNoNormal = -1;

  struct Bounds {
    double lower = -1e30;
    double upper = 1e30;
    int normal = kNoNormal;  // row whose lambda times `friction` bounds this one
    double friction = 0.0;
  };

  DirectSolver();

  // Row-major, of the size given to Solve; only the lower triangle is read.
  [[nodiscard]] double& A(int i, int j) { return A_[At(i, j)]; }
  [[nodiscard]] double& b(int i) { return b_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] Bounds& bounds(int i) { return bounds_[static_cast<std::size_t>(i)]; }
  // In: initial guess. Out: solution.
  [[nodiscard]] double& lambda(int i) { return lambda_[static_cast<std::size_t>(i)]; }

  // num_rows <= kMaxRows. Does not allocate.
  bool Solve(int num_rows);

 private:
  enum class State : std::uint8_t { kFree, kLower, kUpper };

  static std::size_t At(int i, int j) { return static_cast<std::size_t>(i * kMaxRows + j); }
  void BoundFriction(int num_rows);
  void GuessStates(int num_rows);
  [[nodiscard]] double Slope(int i) const;
  bool Eliminate(int num_free);
  bool SolveSliding(int num_rows);
  bool SolveStates(int num_rows);
  bool SolveFree(int num_rows);
  [[nodiscard]] State FindState(int i, int num_rows, double scale) const;
  int Pivot(int num_rows, bool only_last);

  std::vector<double> A_, L_, b_, lambda_, result_, work_;
  std::vector<Bounds> bounds_;
  std::vector<State> states_, wanted_;
  std::vector<int> free_;
  std::vector<int> first_;  // first nonzero column of a free row in L
  std::vector<int> place_;  // index of a row among the free ones; -1: not free
};

}  // namespace physics
