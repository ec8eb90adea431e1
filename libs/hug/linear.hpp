#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace hug {

template <std::size_t N>
using Square = std::array<std::array<double, N>, N>;

// Solves A x = b in place for a symmetric positive definite A by Cholesky's factors, A = L L^T; A becomes L. A pivot
// below `least` is raised to it, so that a singular A gives a bounded x along its range.
template <std::size_t N>
void SolveSymmetric(Square<N>* A, std::array<double, N>* b, double least = 1e-12) {
  auto& L = *A;
  for (std::size_t i = 0; i < N; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = L[i][j];
      for (std::size_t k = 0; k < j; ++k) sum -= L[i][k] * L[j][k];
      L[i][j] = i == j ? std::sqrt(sum > least ? sum : least) : sum / L[j][j];
    }
  }
  auto& x = *b;
  for (std::size_t i = 0; i < N; ++i) {
    for (std::size_t k = 0; k < i; ++k) x[i] -= L[i][k] * x[k];
    x[i] /= L[i][i];
  }
  for (std::size_t i = N; i-- > 0;) {
    for (std::size_t k = i + 1; k < N; ++k) x[i] -= L[k][i] * x[k];
    x[i] /= L[i][i];
  }
}

}  // namespace hug
