#include "physics/engine/direct_solver.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

constexpr int kMaxPivots = 30;  // most systems take one to three; those that take more than this rarely converge
// Iterations without progress before single pivots. With 1 they come too early for rows that reach their bounds
// together (Joints.TwoArmsOnAFreeBase* fails), with 10 too late (DirectSolver.SlidingFrictionIsProportional* fails).
constexpr int kPatience = 3;
constexpr double kTolerance = 1e-10;  // relative to the largest lambda: far above rounding, below the solver's accuracy

// Scalar product with four independent sums, since a single one waits for each addition. Fixes the order of summation.
double Dot(const double* a, const double* b, int n) {
  double sums[4] = {0.0, 0.0, 0.0, 0.0};
  int i = 0;
  for (; i + 4 <= n; i += 4) {
    for (int k = 0; k < 4; ++k) sums[k] += a[i + k] * b[i + k];
  }
  double rest = 0.0;
  for (; i < n; ++i) rest += a[i] * b[i];
  return (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest;
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
      wanted_(kMaxRows),
      free_(kMaxRows),
      first_(kMaxRows),
      place_(kMaxRows) {}

void DirectSolver::BoundFriction(int num_rows) {
  for (int i = 0; i < num_rows; ++i) {
    Bounds& bound = bounds(i);
    if (bound.normal == kNoNormal) continue;
    bound.upper = bound.friction * std::max(0.0, result_[static_cast<std::size_t>(bound.normal)]);
    bound.lower = -bound.upper;
  }
}

// Rows at a bound (B) take its value; the free ones (F) follow from A_FF lambda_F = b_F - A_FB lambda_B, by Cholesky's
// factorisation A_FF = L L^T.
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
    // Row r of L, and forward substitution with it. Rows without a common body do not couple; the zeros of A to the
    // left of a row's first coupling are zeros of L too (skyline), which makes chains of joints cheap.
    double* row = &L_[At(r, 0)];
    int first = 0;
    while (first < r && A(i, free_[static_cast<std::size_t>(first)]) == 0.0) ++first;
    first_[static_cast<std::size_t>(r)] = first;
    for (int c = first; c < r; ++c) {
      const double* other = &L_[At(c, 0)];
      const int from = std::max(first, first_[static_cast<std::size_t>(c)]);
      row[c] = (A(i, free_[static_cast<std::size_t>(c)]) - Dot(row + from, other + from, c - from)) / other[c];
    }
    const double pivot = A(i, i) - Dot(row + first, row + first, r - first);
    if (!(pivot > 0.0)) return false;
    row[r] = std::sqrt(pivot);
    work_[static_cast<std::size_t>(r)] = (right - Dot(row + first, work_.data() + first, r - first)) / row[r];
  }
  for (int r = n - 1; r >= 0; --r) {
    double value = work_[static_cast<std::size_t>(r)];
    for (int c = r + 1; c < n; ++c) {
      if (first_[static_cast<std::size_t>(c)] <= r) value -= L_[At(c, r)] * work_[static_cast<std::size_t>(c)];
    }
    work_[static_cast<std::size_t>(r)] = value / L_[At(r, r)];
    result_[static_cast<std::size_t>(free_[static_cast<std::size_t>(r)])] = work_[static_cast<std::size_t>(r)];
  }
  return true;
}

// The state that a row should have by the present solution (complementarity conditions of the header).
DirectSolver::State DirectSolver::FindState(int i, int num_rows, double scale) const {
  const auto at = static_cast<std::size_t>(i);
  const int normal = bounds_[at].normal;
  // Friction of a contact without normal force is zero.
  if (normal != kNoNormal && states_[static_cast<std::size_t>(normal)] != State::kFree) return State::kLower;
  if (states_[at] == State::kFree) {
    const double slack = kTolerance * scale;
    if (result_[at] < bounds_[at].lower - slack) return State::kLower;
    if (result_[at] > bounds_[at].upper + slack) return State::kUpper;
    return State::kFree;
  }
  double excess = -b_[at];
  for (int j = 0; j < i; ++j) excess += A_[At(i, j)] * result_[static_cast<std::size_t>(j)];
  for (int j = i; j < num_rows; ++j) excess += A_[At(j, i)] * result_[static_cast<std::size_t>(j)];
  const double slack = kTolerance * (scale * A_[At(i, i)] + std::abs(b_[at]));
  if (states_[at] == State::kLower ? excess < -slack : excess > slack) return State::kFree;
  return states_[at];
}

// Changes the state of the rows that violate their conditions, of all or only of the last one. Returns their number.
int DirectSolver::Pivot(int num_rows, bool only_last) {
  double scale = 0.0;
  for (int i = 0; i < num_rows; ++i) scale = std::max(scale, std::abs(result_[static_cast<std::size_t>(i)]));
  int num_wrong = 0;
  int last = 0;
  for (int i = 0; i < num_rows; ++i) {
    const auto at = static_cast<std::size_t>(i);
    wanted_[at] = FindState(i, num_rows, scale);
    if (wanted_[at] == states_[at]) continue;
    last = i;
    ++num_wrong;
  }
  for (int i = only_last ? last : 0; i < num_rows && num_wrong > 0; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (wanted_[at] == states_[at]) continue;
    states_[at] = wanted_[at];
    const bool pushes = wanted_[at] == State::kFree && bounds_[at].normal == kNoNormal;
    // A contact that begins to push is assumed to stick.
    for (int j = 0; j < num_rows && pushes; ++j) {
      if (bounds_[static_cast<std::size_t>(j)].normal == i) {
        states_[static_cast<std::size_t>(j)] = wanted_[static_cast<std::size_t>(j)] = State::kFree;
      }
    }
  }
  return num_wrong;
}

void DirectSolver::GuessStates(int num_rows) {
  for (int i = 0; i < num_rows; ++i) result_[static_cast<std::size_t>(i)] = lambda(i);
  BoundFriction(num_rows);
  for (int i = 0; i < num_rows; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double slack = kTolerance * std::abs(lambda_[at]);
    states_[at] = lambda_[at] <= bounds_[at].lower + slack   ? State::kLower
                  : lambda_[at] >= bounds_[at].upper - slack ? State::kUpper
                                                             : State::kFree;
  }
}

// d lambda / d lambda_normal of a sliding friction row, +-mu; 0 for other rows.
double DirectSolver::Slope(int i) const {
  const auto at = static_cast<std::size_t>(i);
  if (bounds_[at].normal == kNoNormal || states_[at] == State::kFree) return 0.0;
  return states_[at] == State::kUpper ? bounds_[at].friction : -bounds_[at].friction;
}

// Solves L_ x = work_ by Gaussian elimination with row pivoting; overwrites both.
bool DirectSolver::Eliminate(int num_free) {
  for (int c = 0; c < num_free; ++c) {
    int best = c;
    for (int r = c + 1; r < num_free; ++r) {
      if (std::abs(L_[At(r, c)]) > std::abs(L_[At(best, c)])) best = r;
    }
    if (!(std::abs(L_[At(best, c)]) > 0.0)) return false;
    if (best != c) {
      std::swap_ranges(&L_[At(c, c)], &L_[At(c, 0)] + num_free, &L_[At(best, c)]);
      std::swap(work_[static_cast<std::size_t>(c)], work_[static_cast<std::size_t>(best)]);
    }
    for (int r = c + 1; r < num_free; ++r) {
      const double factor = L_[At(r, c)] / L_[At(c, c)];
      if (factor == 0.0) continue;
      for (int k = c + 1; k < num_free; ++k) L_[At(r, k)] -= factor * L_[At(c, k)];
      work_[static_cast<std::size_t>(r)] -= factor * work_[static_cast<std::size_t>(c)];
    }
  }
  for (int r = num_free - 1; r >= 0; --r) {
    double value = work_[static_cast<std::size_t>(r)];
    for (int c = r + 1; c < num_free; ++c) value -= L_[At(r, c)] * work_[static_cast<std::size_t>(c)];
    work_[static_cast<std::size_t>(r)] = value / L_[At(r, r)];
  }
  return true;
}

// As SolveFree, for friction rows t that slide on a free normal n: lambda_t = slope_t lambda_n is inserted into the
// equations, so column n becomes A(., n) + sum_t slope_t A(., t). The matrix is then not symmetric.
bool DirectSolver::SolveSliding(int num_rows) {
  int n = 0;
  for (int i = 0; i < num_rows; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (states_[at] == State::kFree) {
      place_[at] = n;
      free_[static_cast<std::size_t>(n++)] = i;
    } else {
      place_[at] = -1;
      result_[at] = states_[at] == State::kLower ? bounds_[at].lower : bounds_[at].upper;
    }
  }
  const auto a = [this](int i, int j) { return j < i ? A(i, j) : A(j, i); };
  for (int r = 0; r < n; ++r) {
    const int i = free_[static_cast<std::size_t>(r)];
    for (int c = 0; c < n; ++c) L_[At(r, c)] = a(i, free_[static_cast<std::size_t>(c)]);
    double right = b(i);
    for (int j = 0; j < num_rows; ++j) {
      const auto at = static_cast<std::size_t>(j);
      if (states_[at] == State::kFree) continue;
      const int normal = bounds_[at].normal;
      if (normal == kNoNormal) {
        right -= a(i, j) * result_[at];
      } else if (place_[static_cast<std::size_t>(normal)] >= 0) {
        L_[At(r, place_[static_cast<std::size_t>(normal)])] += Slope(j) * a(i, j);
      } else {
        right -= a(i, j) * Slope(j) * std::max(0.0, result_[static_cast<std::size_t>(normal)]);
      }
    }
    work_[static_cast<std::size_t>(r)] = right;
  }
  if (!Eliminate(n)) return false;
  for (int r = 0; r < n; ++r) {
    result_[static_cast<std::size_t>(free_[static_cast<std::size_t>(r)])] = work_[static_cast<std::size_t>(r)];
  }
  for (int i = 0; i < num_rows; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (states_[at] == State::kFree || bounds_[at].normal == kNoNormal) continue;
    result_[at] = Slope(i) * std::max(0.0, result_[static_cast<std::size_t>(bounds_[at].normal)]);
  }
  return true;
}

bool DirectSolver::SolveStates(int num_rows) {
  bool slides = false;
  for (int i = 0; i < num_rows && !slides; ++i) {
    slides = Slope(i) != 0.0 &&
             states_[static_cast<std::size_t>(bounds_[static_cast<std::size_t>(i)].normal)] == State::kFree;
  }
  if (!(slides ? SolveSliding(num_rows) : SolveFree(num_rows))) return false;
  BoundFriction(num_rows);
  return true;
}

// Changes all violating rows at once as long as their number decreases. After kPatience iterations without progress it
// changes one at a time (Murty's rule, which cannot cycle), until there are fewer than ever before.
bool DirectSolver::Solve(int num_rows) {
  GuessStates(num_rows);
  int fewest = num_rows + 1;
  int patience = kPatience;
  for (int pivots = 0; pivots < kMaxPivots; ++pivots) {
    if (!SolveStates(num_rows)) return false;
    const int wrong = Pivot(num_rows, patience == 0);
    if (wrong == 0) {
      std::copy_n(result_.begin(), num_rows, lambda_.begin());
      return true;
    }
    if (wrong < fewest) {
      fewest = wrong;
      patience = kPatience;
    } else if (patience > 0) {
      --patience;
    }
  }
  return false;
}

}  // namespace physics
