#include "physics/engine/direct_solver.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

constexpr int kMaxPivots = 30;          // of the guess, with friction's bounds held
constexpr int kMaxFrictionPasses = 40;  // a sliding contact converges like mu times a lever ratio
constexpr double kTolerance = 1e-10;    // relative to the largest lambda

double Dot(const double* a, const double* b, int n) {
  double sum = 0.0;
  for (int i = 0; i < n; ++i) sum += a[i] * b[i];
  return sum;
}

}  // namespace

DirectSolver::DirectSolver()
    : A_(kMaxRows * kMaxRows),
      L_(kMaxRows * kMaxRows),
      b_(kMaxRows),
      lambda_(kMaxRows),
      result_(kMaxRows),
      work_(kMaxRows),
      bounds_(kMaxRows),
      states_(kMaxRows),
      free_(kMaxRows) {}

void DirectSolver::BoundFriction(int num_rows) {
  for (int i = 0; i < num_rows; ++i) {
    Bounds& bound = bounds(i);
    if (bound.normal == kNoNormal) continue;
    bound.upper = bound.friction * std::max(0.0, result_[static_cast<std::size_t>(bound.normal)]);
    bound.lower = -bound.upper;
  }
}

// Rows at a bound take its value; the others follow from A_FF lambda_F = b_F - A_FB lambda_B.
bool DirectSolver::SolveFree(int num_rows) {
  int n = 0;
  for (int i = 0; i < num_rows; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (states_[at] == State::kFree) {
      free_[static_cast<std::size_t>(n++)] = i;
    } else {
      result_[at] = states_[at] == State::kLower ? bounds_[at].lower : bounds_[at].upper;
    }
  }
  for (int r = 0; r < n; ++r) {
    const int i = free_[static_cast<std::size_t>(r)];
    double right = b(i);
    for (int j = 0; j < num_rows; ++j) {
      if (states_[static_cast<std::size_t>(j)] == State::kFree) continue;
      right -= (j < i ? A(i, j) : A(j, i)) * result_[static_cast<std::size_t>(j)];
    }
    // Row r of Cholesky's L, and forward substitution with it.
    double* row = &L_[At(r, 0)];
    for (int c = 0; c < r; ++c) {
      const double* other = &L_[At(c, 0)];
      row[c] = (A(i, free_[static_cast<std::size_t>(c)]) - Dot(row, other, c)) / other[c];
    }
    const double pivot = A(i, i) - Dot(row, row, r);
    if (!(pivot > 0.0)) return false;
    row[r] = std::sqrt(pivot);
    work_[static_cast<std::size_t>(r)] = (right - Dot(row, work_.data(), r)) / row[r];
  }
  for (int r = n - 1; r >= 0; --r) {
    double value = work_[static_cast<std::size_t>(r)];
    for (int c = r + 1; c < n; ++c) value -= L_[At(c, r)] * work_[static_cast<std::size_t>(c)];
    work_[static_cast<std::size_t>(r)] = value / L_[At(r, r)];
    result_[static_cast<std::size_t>(free_[static_cast<std::size_t>(r)])] = work_[static_cast<std::size_t>(r)];
  }
  return true;
}

// Moves the rows that contradict their state; false when none does.
bool DirectSolver::Pivot(int num_rows) {
  double scale = 0.0;
  for (int i = 0; i < num_rows; ++i) scale = std::max(scale, std::abs(result_[static_cast<std::size_t>(i)]));
  bool any = false;
  for (int i = 0; i < num_rows; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (states_[at] == State::kFree) {
      const double slack = kTolerance * scale;
      if (result_[at] < bounds_[at].lower - slack) {
        states_[at] = State::kLower;
        any = true;
      } else if (result_[at] > bounds_[at].upper + slack) {
        states_[at] = State::kUpper;
        any = true;
      }
      continue;
    }
    double excess = -b(i);
    for (int j = 0; j < num_rows; ++j) excess += (j < i ? A(i, j) : A(j, i)) * result_[static_cast<std::size_t>(j)];
    const double slack = kTolerance * (scale * A(i, i) + std::abs(b(i)));
    if (states_[at] == State::kLower ? excess < -slack : excess > slack) {
      states_[at] = State::kFree;
      any = true;
    }
  }
  return any;
}

bool DirectSolver::Solve(int num_rows) {
  for (int i = 0; i < num_rows; ++i) result_[static_cast<std::size_t>(i)] = lambda(i);
  BoundFriction(num_rows);
  for (int i = 0; i < num_rows; ++i) {
    const auto at = static_cast<std::size_t>(i);
    states_[at] = lambda_[at] <= bounds_[at].lower   ? State::kLower
                  : lambda_[at] >= bounds_[at].upper ? State::kUpper
                                                     : State::kFree;
  }
  for (int pass = 0; pass < kMaxFrictionPasses; ++pass) {
    int pivots = 0;
    do {
      if (pivots++ >= kMaxPivots || !SolveFree(num_rows)) return false;
    } while (Pivot(num_rows));
    BoundFriction(num_rows);
    double scale = 0.0;
    double worst = 0.0;
    for (int i = 0; i < num_rows; ++i) {
      const auto at = static_cast<std::size_t>(i);
      scale = std::max(scale, std::abs(result_[at]));
      if (bounds_[at].normal == kNoNormal) continue;
      if (states_[at] != State::kFree || std::abs(result_[at]) > bounds_[at].upper) {
        worst = std::max(worst, std::abs(std::abs(result_[at]) - bounds_[at].upper));
      }
    }
    if (worst <= kTolerance * scale) {
      std::copy_n(result_.begin(), num_rows, lambda_.begin());
      return true;
    }
  }
  return false;
}

}  // namespace physics
