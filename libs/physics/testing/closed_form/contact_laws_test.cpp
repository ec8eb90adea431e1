#include "physics/testing/closed_form/contact_laws.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <numbers>

namespace physics::closed_form {
namespace {

TEST(Slope, EnergyLossEqualsTheWorkOfFriction) {
  // v^2 / 2 = a s must equal g h - mu g cos(angle) s with h = s sin(angle); at the angle of friction all is lost.
  constexpr double kMu = 0.3;
  constexpr double kG = 9.81;
  const double angle = 1.1 * std::atan(kMu);
  const double s = 2.0;
  EXPECT_NEAR(SlopeAcceleration_m_per_s2(angle, kMu, kG) * s, kG * s * std::sin(angle) - kMu * kG * std::cos(angle) * s,
              1e-13);
  EXPECT_EQ(SlopeAcceleration_m_per_s2(0.999 * std::atan(kMu), kMu, kG), 0.0);
  EXPECT_NEAR(SlopeAcceleration_m_per_s2(0.5 * std::numbers::pi, kMu, kG), kG, 1e-12);
  EXPECT_NEAR(std::atan(kMu) * 180.0 / std::numbers::pi, 16.70, 5e-3);
}

// The delayed equation itself, integrated with steps of 1/2000 of the delay by Heun's method.
double IntegratedRebound(double stiffness, double mass, double delay) {
  const double h = delay / 2000.0;
  std::deque<double> late(2001, 0.0);  // depths, oldest first
  double x = 0.0;
  double v = 1.0;
  // The force acts until the delayed depth is back at zero.
  for (int i = 0; i < 100000000; ++i) {
    const double a0 = -stiffness / mass * late[0];
    const double a1 = -stiffness / mass * late[1];
    x += h * v + 0.5 * h * h * a0;
    v += 0.5 * h * (a0 + a1);
    late.pop_front();
    late.push_back(std::max(0.0, x));
    if (v < 0.0 && late[0] == 0.0 && late[1] == 0.0) break;
  }
  return -v;
}

TEST(DelayedRebound, EqualsTheIntegratedDelayEquation) {
  for (const double w_tau : {0.01, 0.05, 0.1}) {
    const double stiffness = 1e4;
    const double mass = 2.0;
    const double delay = w_tau / std::sqrt(stiffness / mass);
    EXPECT_NEAR(IntegratedRebound(stiffness, mass, delay) / DelayedReboundRatio(stiffness, mass, delay), 1.0,
                1.2 * w_tau * w_tau + 1e-5)
        << w_tau;
  }
}

TEST(DelayedRebound, AnImplicitSpringLosesTheEnergyThatADelayOfOneStepGains) {
  // Backward Euler: the depth is multiplied by 1 / (1 - i w dt) per step, |.| = (1 + w^2 dt^2)^-1/2, over pi / (w dt).
  for (const double w_dt : {0.01, 0.05}) {
    const double exact = std::pow(1.0 + w_dt * w_dt, -0.5 * std::numbers::pi / w_dt);
    EXPECT_NEAR(DelayedReboundRatio(1.0, 1.0, -w_dt) / exact, 1.0, w_dt * w_dt);
  }
}

// Whether some forces within the friction cones hold the peg; searched over the forces at the mouth.
bool HoldsByBruteForce(double l, double r, double mu, double F_x, double F_z, double M) {
  for (int i = 0; i <= 400000; ++i) {
    const double N_mouth = i * 1e-3;
    const double N_tip = N_mouth - F_x;
    if (N_tip < 0.0) continue;
    // t_mouth + t_tip = F_z, M = l N_mouth + r (t_mouth - t_tip)
    const double difference = (M - l * N_mouth) / r;
    const double t_mouth = 0.5 * (F_z + difference);
    const double t_tip = 0.5 * (F_z - difference);
    if (std::abs(t_mouth) <= mu * N_mouth && std::abs(t_tip) <= mu * N_tip) return true;
  }
  return false;
}

TEST(Peg, JamsExactlyWhenItsFrictionConesCanHoldTheLoad) {
  const double r = 0.01;
  const double mu = 0.2;
  for (const double l : {0.008, 0.02, 0.05}) {
    for (const double F_x : {-3.0, 0.0, 5.0}) {
      const double limit = JammingMoment_Nm(l, r, mu, F_x, 20.0);
      ASSERT_FALSE(CanWedge(l, r, mu));
      EXPECT_FALSE(HoldsByBruteForce(l, r, mu, F_x, 20.0, 0.995 * limit)) << l << " " << F_x;
      EXPECT_TRUE(HoldsByBruteForce(l, r, mu, F_x, 20.0, 1.005 * limit)) << l << " " << F_x;
    }
  }
}

TEST(Peg, OffCentrePushJamsLikeADrawer) {
  // Pushed at a distance e beside its axis it jams for e > l / (2 mu), whatever the force.
  for (const double force : {1.0, 100.0}) {
    EXPECT_NEAR(JammingMoment_Nm(0.03, 0.01, 0.25, 0.0, force) / force, 0.03 / (2.0 * 0.25), 1e-15);
  }
}

TEST(Peg, CanWedgeOnlyWhereItIsHeldWithoutLoad) {
  const double r = 0.01;
  const double mu = 0.2;
  EXPECT_TRUE(CanWedge(0.0039, r, mu));
  EXPECT_FALSE(CanWedge(0.0041, r, mu));
  // Squeezed by 10 N at both points the frictions must balance the couple: t_mouth = -t_tip = -l N / (2 r).
  EXPECT_LE(0.0039 * 10.0 / (2.0 * r), mu * 10.0);
  EXPECT_GT(0.0041 * 10.0 / (2.0 * r), mu * 10.0);
}

}  // namespace
}  // namespace physics::closed_form
