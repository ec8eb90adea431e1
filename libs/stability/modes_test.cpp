#include "stability/modes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace stability {
namespace {

Matrix6 Diagonal(double translation, double rotation) {
  Matrix6 A{};
  for (std::size_t i = 0; i < 6; ++i) A[i][i] = i < 3 ? translation : rotation;
  return A;
}

// A spring K along x at the height r above the point of reference: F = -K (x + r phi_y), torque r F about y.
Matrix6 SpringAtALever(double K, double r) {
  Matrix6 A = Diagonal(1.0, 1e-3);
  A[0][0] = K;
  A[0][4] = A[4][0] = K * r;
  A[4][4] = K * r * r + 1e-3;
  return A;
}

TEST(Modes, DiagonaliseMassAndStiffnessTogether) {
  Matrix6 M = Diagonal(1.5, 0.03);
  M[0][4] = M[4][0] = 0.06;
  M[1][2] = M[2][1] = 0.2;
  const Matrix6 K = SpringAtALever(4000.0, 0.1);
  const std::array<Mode, 6> modes = Modes(M, K);
  for (std::size_t a = 0; a < 6; ++a) {
    for (std::size_t b = 0; b < 6; ++b) {
      double mass = 0.0;
      double stiffness = 0.0;
      for (std::size_t i = 0; i < 6; ++i) {
        for (std::size_t j = 0; j < 6; ++j) {
          mass += modes[a].shape[i] * M[i][j] * modes[b].shape[j];
          stiffness += modes[a].shape[i] * K[i][j] * modes[b].shape[j];
        }
      }
      EXPECT_NEAR(mass, a == b ? 1.0 : 0.0, 1e-12);
      EXPECT_NEAR(stiffness, a == b ? modes[a].stiffness_per_s2 : 0.0, 1e-8);
    }
  }
}

TEST(Modes, ALeverLowersTheStableStiffnessByTheMassFeltThere) {
  // At the lever the device weighs 1 / (1/m + r^2/I).
  const double m = 1.5, inertia = 0.03, r = 0.15;
  SampledBody body{Diagonal(m, inertia), {}, 1e-3, 2e-3};
  const double felt_kg = 1.0 / (1.0 / m + r * r / inertia);
  const double K = 4000.0;
  const Matrix6 spring = SpringAtALever(K, r);
  // Damping of the same form: B = 0.004 s K.
  Matrix6 B{};
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) B[i][j] = 0.004 * spring[i][j];
  }
  const double expected = MaxStiffness({felt_kg, 0.0, 1e-3, 2e-3}, 0.004 * K) / K;
  EXPECT_NEAR(LargestStableShare(body, spring, B) / expected, 1.0, 1e-3);
  EXPECT_GT(MaxStiffness({m, 0.0, 1e-3, 2e-3}, 0.004 * K) / K, 1.01 * expected);
}

// Two coupled degrees of freedom, sampled and delayed by two periods, in the plane of x and the rotation about y.
double LateOverEarly(const SampledBody& body, const Matrix6& K, const Matrix6& B, double share) {
  const double T = body.period_s;
  double x[2] = {1e-4, -3e-4}, v[2] = {}, previous[2] = {x[0], x[1]};
  double delayed[2][2] = {};
  const std::size_t axis[2] = {0, 4};
  double early = 0.0;
  double late = 0.0;
  constexpr int kSamples = 40000;
  for (int k = 0; k < kSamples; ++k) {
    double F[2];
    for (int i = 0; i < 2; ++i) {
      F[i] = 0.0;
      for (int j = 0; j < 2; ++j) {
        F[i] -= share * K[axis[i]][axis[j]] * x[j] + B[axis[i]][axis[j]] * (x[j] - previous[j]) / T;
      }
    }
    for (int i = 0; i < 2; ++i) {
      previous[i] = x[i];
      const double a = delayed[1][i] / body.M[axis[i]][axis[i]];
      x[i] += T * v[i] + 0.5 * T * T * a;
      v[i] += T * a;
      delayed[1][i] = delayed[0][i];
      delayed[0][i] = F[i];
    }
    const double size = std::abs(x[0]) + 0.15 * std::abs(x[1]);
    if (k > 4000 && k < 8000) early = std::max(early, size);
    if (k > kSamples - 4000) late = std::max(late, size);
    if (size > 1.0) return 1e9;
  }
  return late / early;
}

TEST(Modes, ASimulatedDeviceWithALeverIsStableBelowTheSmallestModesBoundaryAndUnstableAbove) {
  SampledBody body{Diagonal(1.5, 0.03), {}, 1e-3, 2e-3};
  // Two springs, so that both modes are stiff: 4000 N/m at 0.15 m and 60 Nm/rad.
  Matrix6 K = SpringAtALever(4000.0, 0.15);
  K[4][4] += 60.0;
  Matrix6 B{};
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) B[i][j] = 0.004 * K[i][j];
  }
  const double share = LargestStableShare(body, K, B);
  EXPECT_LT(LateOverEarly(body, K, B, 0.99 * share), 1.0);
  EXPECT_GT(LateOverEarly(body, K, B, 1.01 * share), 1.0);
  EXPECT_EQ(IsStable(body, K, B), share > 1.0);
}

}  // namespace
}  // namespace stability
