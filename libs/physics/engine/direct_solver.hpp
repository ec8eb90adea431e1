#pragma once

#include <cstdint>
#include <vector>

namespace physics {

// A lambda = b within bounds: for each row either lo < lambda < hi and (A lambda - b) = 0, or lambda = lo and
// (A lambda - b) >= 0, or lambda = hi and (A lambda - b) <= 0. Rows of friction have bounds -+ friction * lambda of
// their normal row. A is symmetric positive definite (softness on its diagonal).
//
// Block principal pivoting [Judice and Pires 1994]: guess which rows are at a bound, solve the others by Cholesky's
// factors, move the rows that contradict the guess, again. A row of friction at its bound is +-friction times its
// normal's lambda, which goes into the equations (no longer symmetric, so by elimination). It is not sure to end: Solve
// then says so after 30 guesses and leaves lambda as it was.
class DirectSolver {
 public:
  static constexpr int kMaxRows = 128;
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
  // In: first guess. Out: solution.
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
  [[nodiscard]] State Wanted(int i, int num_rows, double scale) const;
  int Pivot(int num_rows, bool only_last);

  std::vector<double> A_, L_, b_, lambda_, result_, work_;
  std::vector<Bounds> bounds_;
  std::vector<State> states_, wanted_;
  std::vector<int> free_;
  std::vector<int> first_;  // column of L that a free row begins with
  std::vector<int> place_;  // of a row among the free ones, or -1
};

}  // namespace physics
