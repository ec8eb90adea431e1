#include "physics/engine/contact_law.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "physics/testing/trials/build.hpp"

namespace physics {
namespace {

using trials::kDt;

double Potential(double k, double gap) {
  const double depth = std::min(gap, 0.0);
  return 0.5 * k * depth * depth;
}

// A mass that hits a plane: solves m (v1 - v0) = dt F(v1) for v1 by bisection.
double EndSpeed(const ContactLaw& law, double mass, double v0) {
  double low = v0;
  double high = v0 + 1e3;
  for (int i = 0; i < 200; ++i) {
    const double v1 = 0.5 * (low + high);
    const double force = std::max(0.0, CompliantForce(law, 1.0 / mass, v0, v1, kDt).force_N);
    (mass * (v1 - v0) > kDt * force ? high : low) = v1;
  }
  return 0.5 * (low + high);
}

ContactLaw Spring(double gap, double k, double d = 0.0) {
  return {.gap_m = gap, .stiffness_N_per_m = k, .damping_N_s_per_m = d, .pair_stiffness_N_per_m = k};
}

TEST(ContactLaw, ConservesEnergyWhereverInTheStepContactBegins) {
  const double k = 1e4;
  const double m = 0.2;
  for (const double gap : {3e-4, 1e-4, 1e-6, 0.0, -1e-5, -2e-4, -1e-3}) {
    for (const double v0 : {-1.0, -0.1, -1e-3, 0.0, 0.1, 1.0}) {
      const double v1 = EndSpeed(Spring(gap, k), m, v0);
      const double before = 0.5 * m * v0 * v0 + Potential(k, gap - 0.5 * kDt * v0);
      const double after = 0.5 * m * v1 * v1 + Potential(k, gap + 0.5 * kDt * v1);
      EXPECT_NEAR(after, before, 1e-12 * (1.0 + before)) << gap << " m, " << v0 << " m/s";
    }
  }
}

TEST(ContactLaw, SlopeEqualsTheDerivativeOfTheForce) {
  for (const double k : {1e4, 1e5, 1e7}) {  // lossless, between, implicit at 0.2 kg
    for (const double gap : {2e-4, -1e-6, -2e-4}) {
      for (const double v0 : {-0.5, -0.05, 0.3}) {
        for (const double v1 : {-0.4, -0.06, 0.01}) {
          const ContactLaw law = Spring(gap, k, gap < 0.0 ? 20.0 : 0.0);
          const double h = 1e-7;
          const double up = CompliantForce(law, 5.0, v0, v1 + h, kDt).force_N;
          const double down = CompliantForce(law, 5.0, v0, v1 - h, kDt).force_N;
          const double slope = CompliantForce(law, 5.0, v0, v1, kDt).slope_N_s_per_m;
          EXPECT_NEAR((down - up) / (2 * h), slope, 1e-4 * (1.0 + slope)) << k << ' ' << gap << ' ' << v0 << ' ' << v1;
        }
      }
    }
  }
}

TEST(ContactLaw, TransitionToTheImplicitSpringIsContinuous) {
  const double m = 0.2;
  const double gap = -1e-4;
  const double v0 = -0.1;
  EXPECT_EQ(ImplicitShare(0.49 * m / (kDt * kDt), 1.0 / m, kDt), 0.0);
  EXPECT_EQ(ImplicitShare(2.01 * m / (kDt * kDt), 1.0 / m, kDt), 1.0);
  double last = EndSpeed(Spring(gap, 0.4 * m / (kDt * kDt)), m, v0);
  for (int percent = 41; percent < 220; ++percent) {
    const double s = percent / 100.0;
    const double now = EndSpeed(Spring(gap, s * m / (kDt * kDt)), m, v0);
    EXPECT_LT(std::abs(now - last), 5e-3) << s;
    last = now;
  }
  // Fully implicit: v1 = (m v0 - dt k g0) / (m + dt^2 k).
  const double k = 10.0 * m / (kDt * kDt);
  EXPECT_NEAR(EndSpeed(Spring(gap, k), m, v0), (m * v0 - kDt * k * gap) / (m + kDt * kDt * k), 1e-12);
}

TEST(ContactLaw, HardContactTouchesAtTheEndOfTheStepAndSeparatesSlowly) {
  EXPECT_DOUBLE_EQ(HardSpeed_m_per_s(1e-4, kDt), -0.1);
  EXPECT_DOUBLE_EQ(HardSpeed_m_per_s(0.0, kDt), 0.0);
  EXPECT_DOUBLE_EQ(HardSpeed_m_per_s(-1e-5, kDt), 0.002);
  EXPECT_DOUBLE_EQ(HardSpeed_m_per_s(-1.0, kDt), 0.02);
}

}  // namespace
}  // namespace physics
