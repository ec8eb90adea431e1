#include "stability/modes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stability {
namespace {

constexpr std::size_t kSize = 6;
constexpr double kRounding = 1e-12;  // relative, of a mode without stiffness

// Lower L with M = L L^T.
Matrix6 Cholesky(const Matrix6& M) noexcept {
  Matrix6 L{};
  for (std::size_t i = 0; i < kSize; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = M[i][j];
      for (std::size_t k = 0; k < j; ++k) sum -= L[i][k] * L[j][k];
      L[i][j] = i == j ? std::sqrt(sum) : sum / L[j][j];
    }
  }
  return L;
}

// L^-1 A, column by column.
Matrix6 SolveLower(const Matrix6& L, Matrix6 A) noexcept {
  for (std::size_t column = 0; column < kSize; ++column) {
    for (std::size_t i = 0; i < kSize; ++i) {
      for (std::size_t k = 0; k < i; ++k) A[i][column] -= L[i][k] * A[k][column];
      A[i][column] /= L[i][i];
    }
  }
  return A;
}

Matrix6 Transpose(const Matrix6& A) noexcept {
  Matrix6 T{};
  for (std::size_t i = 0; i < kSize; ++i) {
    for (std::size_t j = 0; j < kSize; ++j) T[i][j] = A[j][i];
  }
  return T;
}

// A <- R^T A R and V <- V R, R the rotation in the plane (p, q) that makes A[p][q] zero.
void Rotate(Matrix6* A, Matrix6* V, std::size_t p, std::size_t q) noexcept {
  const double off = (*A)[p][q];
  if (off == 0.0) return;
  const double half_cotangent = ((*A)[q][q] - (*A)[p][p]) / (2.0 * off);
  const double t = std::copysign(1.0, half_cotangent) /
                   (std::abs(half_cotangent) + std::sqrt(1.0 + half_cotangent * half_cotangent));
  const double c = 1.0 / std::sqrt(1.0 + t * t);
  const double s = t * c;
  const auto mix = [c, s](double* u, double* v) {
    const double old = *u;
    *u = c * old - s * *v;
    *v = s * old + c * *v;
  };
  for (std::size_t k = 0; k < kSize; ++k) mix(&(*A)[k][p], &(*A)[k][q]);
  for (std::size_t k = 0; k < kSize; ++k) mix(&(*A)[p][k], &(*A)[q][k]);
  for (std::size_t k = 0; k < kSize; ++k) mix(&(*V)[k][p], &(*V)[k][q]);
}

double Along(const std::array<double, 6>& shape, const Matrix6& A) noexcept {
  double sum = 0.0;
  for (std::size_t i = 0; i < kSize; ++i) {
    for (std::size_t j = 0; j < kSize; ++j) sum += shape[i] * A[i][j] * shape[j];
  }
  return sum;
}

SampledAxis AxisOf(const SampledBody& body, const Mode& mode) noexcept {
  return {1.0, Along(mode.shape, body.b), body.period_s, body.delay_s};
}

}  // namespace

std::array<Mode, 6> Modes(const Matrix6& M, const Matrix6& K) noexcept {
  const Matrix6 L = Cholesky(M);
  Matrix6 A = SolveLower(L, Transpose(SolveLower(L, K)));  // L^-1 K L^-T
  Matrix6 V{};
  for (std::size_t i = 0; i < kSize; ++i) V[i][i] = 1.0;
  constexpr int kSweeps = 12;  // cyclic Jacobi converges quadratically; six sweeps suffice for 6 x 6
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (std::size_t p = 0; p < kSize; ++p) {
      for (std::size_t q = p + 1; q < kSize; ++q) Rotate(&A, &V, p, q);
    }
  }
  std::array<Mode, 6> modes;
  for (std::size_t m = 0; m < kSize; ++m) {
    modes[m].stiffness_per_s2 = A[m][m];
    for (std::size_t i = kSize; i-- > 0;) {  // shape = L^-T v
      double sum = V[i][m];
      for (std::size_t k = i + 1; k < kSize; ++k) sum -= L[k][i] * modes[m].shape[k];
      modes[m].shape[i] = sum / L[i][i];
    }
  }
  return modes;
}

// A wall with given damping is stable below its largest K, so a mode that is stable at the share found so far cannot
// lower it. Beginning with the stiffest mode, most need that one test and no search.
double LargestStableShare(const SampledBody& body, const Matrix6& K, const Matrix6& B) noexcept {
  std::array<Mode, 6> modes = Modes(body.M, K);
  std::sort(modes.begin(), modes.end(),
            [](const Mode& a, const Mode& b) { return a.stiffness_per_s2 > b.stiffness_per_s2; });
  double share = std::numeric_limits<double>::infinity();
  for (const Mode& mode : modes) {
    if (mode.stiffness_per_s2 <= kRounding * modes.front().stiffness_per_s2) break;  // no wall in this direction
    const SampledAxis axis = AxisOf(body, mode);
    const double damping = Along(mode.shape, B);
    if (share < std::numeric_limits<double>::infinity() && IsStable(axis, {share * mode.stiffness_per_s2, damping}))
      continue;
    share = std::min(share, MaxStiffness(axis, damping) / mode.stiffness_per_s2);
  }
  return share;
}

bool IsStable(const SampledBody& body, const Matrix6& K, const Matrix6& B) noexcept {
  return LargestStableShare(body, K, B) > 1.0;
}

}  // namespace stability
