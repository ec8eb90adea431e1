#include "nodes/device_bridge/arms/oscillator.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

namespace device_bridge {
namespace {

// Independent solution in long double, from the distinct complex roots of the characteristic equation.
OscillatorState ByComplexRoots(const Oscillator& axis, const OscillatorState& state, double force, double t) {
  using C = std::complex<long double>;
  const long double a = 0.5L * axis.damping / axis.mass;
  const long double w = static_cast<long double>(axis.stiffness) / axis.mass;
  const C root = std::sqrt(C(a * a - w, 0));
  const C r1 = -a + root;
  const C r2 = -a - root;
  const long double rest = static_cast<long double>(force) / axis.stiffness;
  const long double y0 = state.position - rest;
  const C c1 = (C(state.velocity, 0) - r2 * C(y0, 0)) / (r1 - r2);
  const C c2 = C(y0, 0) - c1;
  const C e1 = std::exp(r1 * C(t, 0));
  const C e2 = std::exp(r2 * C(t, 0));
  return {static_cast<double>((c1 * e1 + c2 * e2).real() + rest),
          static_cast<double>((c1 * r1 * e1 + c2 * r2 * e2).real())};
}

TEST(Oscillator, ZeroOrderHoldStepEqualsTheClosedFormTo1e12) {
  const OscillatorState start{0.013, -0.21};
  for (const double mass : {0.03, 1.5, 5.0}) {
    for (const double damping : {0.0, 0.05, 5.0, 65.0, 400.0, 20000.0}) {
      for (const double stiffness : {0.4, 25.0, 800.0, 1.0e5, 1.0e7}) {
        for (const double dt_s : {1e-5, 2.5e-4, 1e-3, 0.05, 1.0}) {
          const Oscillator axis{mass, damping, stiffness};
          const double force = 3.7;
          const OscillatorState exact = ByComplexRoots(axis, start, force, dt_s);
          const OscillatorState step = StepExactly(axis, start, force, dt_s);
          const double scale = std::max(1.0, force / stiffness);
          EXPECT_NEAR(step.position, exact.position, 1e-12 * scale)
              << mass << ' ' << damping << ' ' << stiffness << ' ' << dt_s;
          const double velocity_scale = std::max(1.0, std::sqrt(stiffness / mass) * std::abs(start.position));
          EXPECT_NEAR(step.velocity, exact.velocity, 1e-11 * velocity_scale)
              << mass << ' ' << damping << ' ' << stiffness << ' ' << dt_s;
        }
      }
    }
  }
}

TEST(Oscillator, IsExactForAFreeMassAPureDamperAndCriticalDamping) {
  const OscillatorState fall = StepExactly({2.0, 0.0, 0.0}, {0.1, 0.3}, 4.0, 0.5);
  EXPECT_NEAR(fall.position, 0.1 + 0.3 * 0.5 + 0.5 * 2.0 * 0.25, 1e-14);
  EXPECT_NEAR(fall.velocity, 1.3, 1e-14);
  // m v' = -c v: v = v0 exp(-c t/m), y = y0 + v0 (m/c)(1 - exp(-c t/m)).
  for (const double dt_s : {1e-3, 0.4, 3.0}) {
    const OscillatorState coast = StepExactly({1.5, 5.0, 0.0}, {0.0, 0.3}, 0.0, dt_s);
    EXPECT_NEAR(coast.velocity, 0.3 * std::exp(-5.0 * dt_s / 1.5), 1e-14);
    EXPECT_NEAR(coast.position, 0.3 * 0.3 * -std::expm1(-5.0 * dt_s / 1.5), 1e-14);
  }
  // Critically damped: y = (y0 + (v0 + a y0) t) exp(-a t).
  const double a = std::sqrt(800.0 / 1.5);
  const OscillatorState critical = StepExactly({1.5, 2.0 * 1.5 * a, 800.0}, {0.01, 0.2}, 0.0, 0.02);
  EXPECT_NEAR(critical.position, (0.01 + (0.2 + a * 0.01) * 0.02) * std::exp(-a * 0.02), 1e-14);
}

TEST(Oscillator, TwoStepsEqualOneStepOfTheirLength) {
  const Oscillator axis{1.5, 65.0, 800.0};
  const OscillatorState once = StepExactly(axis, {0.02, 0.1}, -3.0, 1e-2);
  const OscillatorState twice = StepExactly(axis, StepExactly(axis, {0.02, 0.1}, -3.0, 4e-3), -3.0, 6e-3);
  EXPECT_NEAR(once.position, twice.position, 1e-15);
  EXPECT_NEAR(once.velocity, twice.velocity, 1e-14);
}

TEST(Oscillator, EnergyNeverGrowsAtAnyStiffness) {
  for (const double stiffness : {1e3, 1e6, 1e9, 1e12}) {
    const Oscillator axis{1.5, 1.0, stiffness};
    OscillatorState state{0.01, 0.0};
    double energy = 0.5 * stiffness * 1e-4;
    for (int i = 0; i < 1000; ++i) {
      state = StepExactly(axis, state, 0.0, 1e-3);
      const double now = 0.5 * stiffness * state.position * state.position + 0.75 * state.velocity * state.velocity;
      EXPECT_LE(now, energy * (1.0 + 1e-9));
      energy = now;
    }
  }
}

}  // namespace
}  // namespace device_bridge
