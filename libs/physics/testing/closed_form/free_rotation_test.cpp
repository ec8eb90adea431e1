#include "physics/testing/closed_form/free_rotation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "physics/testing/closed_form/jacobi_elliptic.hpp"

namespace physics::closed_form {
namespace {

double Complement(double modulus) {
  return std::sqrt(1.0 - modulus * modulus);
}

TEST(JacobiElliptic, IntegralsEqualThoseOfTheStandardLibrary) {
  for (const double k : {0.0, 0.1, 0.5, 0.9, 0.999}) {
    EXPECT_NEAR(CompleteEllipticK(Complement(k)), std::comp_ellint_1(k), 1e-12) << k;
    for (const double phi : {-1.5, -0.3, 0.0, 0.7, 1.2, 1.57, 2.0, 4.0, -7.0}) {
      EXPECT_NEAR(IncompleteEllipticF(phi, Complement(k)), std::ellint_1(k, phi), 1e-12) << k << " " << phi;
    }
  }
}

TEST(JacobiElliptic, FunctionsInvertTheIntegral) {
  for (const double complement : {1.0, 0.5, 1e-3, 1e-9}) {
    for (const double phi : {-1.4, -0.2, 0.3, 1.0, 1.5, 2.5, 5.0}) {
      const JacobiElliptic f = EvaluateJacobi(IncompleteEllipticF(phi, complement), complement);
      EXPECT_NEAR(f.sn, std::sin(phi), 1e-11) << complement << " " << phi;
      EXPECT_NEAR(f.cn, std::cos(phi), 1e-11) << complement << " " << phi;
      EXPECT_NEAR(f.dn * f.dn + (1.0 - complement * complement) * f.sn * f.sn, 1.0, 1e-14);
    }
  }
}

TEST(JacobiElliptic, BecomeTrigonometricAndHyperbolicAtTheLimits) {
  for (const double u : {-2.0, 0.3, 1.0, 4.0}) {
    EXPECT_NEAR(EvaluateJacobi(u, 1.0).sn, std::sin(u), 1e-14);
    EXPECT_NEAR(EvaluateJacobi(u, 1.0).cn, std::cos(u), 1e-14);
    EXPECT_NEAR(EvaluateJacobi(u, 1e-10).sn, std::tanh(u), 1e-12);
    EXPECT_NEAR(EvaluateJacobi(u, 1e-10).dn, 1.0 / std::cosh(u), 1e-12);
  }
}

glm::dvec3 EulerRates(const glm::dvec3& I, const glm::dvec3& w) {
  return glm::cross(I * w, w) / I;
}

// An independent solution: Euler's equations, integrated by the Runge-Kutta method of fourth order at 0.1 ms.
glm::dvec3 Integrate(const glm::dvec3& I, glm::dvec3 w, double t_s) {
  const int n = static_cast<int>(std::lround(t_s / 1e-4));
  for (int i = 0; i < n; ++i) {
    const double h = t_s / n;
    const glm::dvec3 k1 = EulerRates(I, w);
    const glm::dvec3 k2 = EulerRates(I, w + 0.5 * h * k1);
    const glm::dvec3 k3 = EulerRates(I, w + 0.5 * h * k2);
    const glm::dvec3 k4 = EulerRates(I, w + h * k3);
    w += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  return w;
}

TEST(FreeRotation, SolvesEulersEquationsForEveryOrderOfAxesAndSigns) {
  std::vector<glm::dvec3> moments{{1, 2, 3}, {1, 3, 2}, {2, 1, 3}, {2, 3, 1}, {3, 1, 2}, {3, 2, 1}};
  for (const glm::dvec3& I : moments) {
    for (const glm::dvec3& w : {glm::dvec3(0.3, 1.1, -0.7), {-2.0, 0.1, 0.4}, {0.5, -0.6, 2.0}, {-0.4, 1.5, 0.2}}) {
      const FreeRotation exact(I, w);
      for (const double t : {0.0, 0.5, 3.0, 10.0}) {
        EXPECT_LT(glm::length(exact.w_B_rad_per_s(t) - Integrate(I, w, t)), 1e-10) << t;
      }
      EXPECT_LT(glm::length(exact.w_B_rad_per_s(exact.period_s()) - w), 1e-12);
    }
  }
}

TEST(FreeRotation, MiddleAxisRatePassesZeroAtTheFlips) {
  const glm::dvec3 I(1, 2, 3);
  const FreeRotation tumbling(I, {0.01, 2.0, 0.01});
  for (int n = 0; n < 5; ++n) {
    const double t = tumbling.flip_s(n);
    EXPECT_NEAR(tumbling.w_B_rad_per_s(t).y, 0.0, 1e-11);
    EXPECT_LT(tumbling.w_B_rad_per_s(t - 0.01).y * tumbling.w_B_rad_per_s(t + 0.01).y, 0.0);
  }
  EXPECT_NEAR(2.0 * (tumbling.flip_s(1) - tumbling.flip_s(0)), tumbling.period_s(), 1e-12);
}

TEST(FreeRotation, SmallTiltNutatesAtTheRateOfTheLinearisedEquations) {
  // About the largest moment: w1, w2 oscillate at w3 sqrt((I3 - I1)(I3 - I2) / (I1 I2)).
  const FreeRotation exact({1.0, 2.0, 3.0}, {1e-6, 0.0, 2.0});
  EXPECT_NEAR(exact.period_s(), 2.0 * std::numbers::pi / (2.0 * std::sqrt(2.0 * 1.0 / 2.0)), 1e-10);
}

}  // namespace
}  // namespace physics::closed_form
