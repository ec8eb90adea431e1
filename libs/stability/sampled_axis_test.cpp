#include "stability/sampled_axis.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <vector>

namespace stability {
namespace {

SampledAxis Axis(double mass_kg, double damping_N_s_per_m, double period_s, double delay_s) {
  return {mass_kg, damping_N_s_per_m, period_s, delay_s};
}

// The device of the closed forms: m = 1 kg, b = 0, T = 1 s, so that K is alpha and B is beta.
SampledAxis Undamped(double d) {
  return Axis(1.0, 0.0, 1.0, d);
}

// Advances m x'' = F - b x' by the classical Runge-Kutta method: independent of the closed forms of the library.
struct Motion {
  double x = 0.0;
  double v = 0.0;
  void Advance(const SampledAxis& axis, double force_N, double time_s) {
    constexpr int kSteps = 4;
    const double h = time_s / kSteps;
    const auto acceleration = [&](double speed) { return (force_N - axis.damping_N_s_per_m * speed) / axis.mass_kg; };
    for (int i = 0; i < kSteps; ++i) {
      const double a1 = acceleration(v);
      const double a2 = acceleration(v + 0.5 * h * a1);
      const double a3 = acceleration(v + 0.5 * h * a2);
      const double a4 = acceleration(v + h * a3);
      x += h * v + h * h / 6.0 * (a1 + a2 + a3);
      v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    }
  }
};

// Positions at each sample of a device that hits a wall at x = 0 and stays coupled to it.
std::vector<double> Simulate(const SampledAxis& axis, const Wall& wall, double speed_m_per_s, int num_samples) {
  const double T = axis.period_s;
  const auto whole = static_cast<std::size_t>(axis.delay_s / T);
  const double rest_s = axis.delay_s - static_cast<double>(whole) * T;
  std::deque<double> forces(whole + 2, 0.0);  // newest last; the two oldest act in this period
  std::vector<double> positions;
  Motion motion{0.0, speed_m_per_s};
  double previous = 0.0;
  for (int i = 0; i < num_samples; ++i) {
    positions.push_back(motion.x);
    forces.push_back(-wall.stiffness_N_per_m * motion.x - wall.damping_N_s_per_m * (motion.x - previous) / T);
    forces.pop_front();
    previous = motion.x;
    motion.Advance(axis, forces[0], rest_s);
    motion.Advance(axis, forces[1], T - rest_s);
  }
  return positions;
}

double Largest(const std::vector<double>& x, std::size_t begin, std::size_t end) {
  double largest = 0.0;
  for (std::size_t i = begin; i < end; ++i) largest = std::max(largest, std::abs(x[i]));
  return largest;
}

// Compares the largest excursions of two spans, each of which holds many swings.
bool Decays(const SampledAxis& axis, const Wall& wall) {
  const double swing = 2.0 * M_PI * std::sqrt(axis.mass_kg / wall.stiffness_N_per_m) / axis.period_s;
  const auto span = static_cast<std::size_t>(std::max(8.0 * swing, 200.0));
  const std::vector<double> x = Simulate(axis, wall, 0.1, static_cast<int>(8 * span));
  return Largest(x, 7 * span, 8 * span) < Largest(x, span, 2 * span);
}

TEST(SampledAxis, WithoutDelayTheBoundaryIsTheClosedForm) {
  for (const double beta : {0.02, 0.3, 0.828, 1.3, 1.9}) {
    EXPECT_NEAR(MaxStiffness(Undamped(0.0), beta), 2.0 * beta * (2.0 - beta) / (2.0 + beta), 1e-9) << beta;
  }
}

TEST(SampledAxis, WithWholeDelaysTheBoundaryIsTheClosedForm) {
  for (const int d : {1, 2, 3, 5, 10, 40}) {
    for (const double share : {1e-3, 3e-3, 0.01, 0.1, 0.35, 0.6, 0.9}) {
      const double angle = share * M_PI / (2.0 * (d + 1.0));
      const double alpha = 4.0 * std::pow(std::tan(0.5 * angle), 2) * std::cos((d + 1.0) * angle);
      const double beta =
          2.0 * std::sin(0.5 * angle) * std::sin((d + 0.5) * angle) / std::pow(std::cos(0.5 * angle), 2);
      EXPECT_NEAR(MaxStiffness(Undamped(d), beta) / alpha, 1.0, share < 0.1 ? 3e-4 : 1e-6) << d << ' ' << beta;
    }
  }
}

TEST(SampledAxis, TheStiffestWallsAreThePublishedOnes) {
  const struct {
    double d, alpha, beta;
  } published[] = {{0, 0.68629, 0.82843}, {1, 0.14447, 0.42456}, {2, 0.06243, 0.29141},
                   {3, 0.03478, 0.22244}, {5, 0.01535, 0.15112}, {10, 0.00455, 0.08403}};
  for (const auto& p : published) {
    const Wall wall = StiffestWall(Undamped(p.d));
    EXPECT_NEAR(wall.stiffness_N_per_m, p.alpha, 6e-6) << p.d;
    EXPECT_NEAR(wall.damping_N_s_per_m, p.beta, 1e-3 * p.beta) << p.d;
  }
}

TEST(SampledAxis, TheLargestDampingIsThePublishedOne) {
  const struct {
    double d, beta;
  } published[] = {{0, 2.0}, {1, 0.82843}, {2, 0.53590}, {3, 0.39782}, {5, 0.26330}, {10, 0.14304}};
  for (const auto& p : published) {
    const std::optional<DampingRange> range = StableDamping(Undamped(p.d), 1e-7);
    ASSERT_TRUE(range) << p.d;
    EXPECT_NEAR(range->most_N_s_per_m, p.beta, 2e-5) << p.d;
  }
}

TEST(SampledAxis, LargestStiffnessAndStableDampingAreTheSameCurve) {
  for (const SampledAxis& axis :
       {Axis(1.5, 5.0, 1e-3, 2.8e-3), Axis(0.5, 0.0, 1e-3, 0.0), Axis(5.0, 10.0, 1e-3, 0.4e-3)}) {
    const double K = 0.6 * StiffestWall(axis).stiffness_N_per_m;
    const std::optional<DampingRange> range = StableDamping(axis, K);
    ASSERT_TRUE(range);
    EXPECT_NEAR(MaxStiffness(axis, range->most_N_s_per_m) / K, 1.0, 1e-6);
    EXPECT_NEAR(MaxDamping(axis, {K, 1.01 * range->least_N_s_per_m}) / range->most_N_s_per_m, 1.0, 1e-6);
    EXPECT_EQ(MaxDamping(axis, {K, 1.01 * range->most_N_s_per_m}), 0.0);
    EXPECT_NEAR(MaxStiffness(axis, range->least_N_s_per_m) / K, 1.0, 1e-6);
  }
  const SampledAxis axis = Axis(1.5, 0.0, 1e-3, 2.8e-3);
  EXPECT_FALSE(StableDamping(axis, 1.01 * StiffestWall(axis).stiffness_N_per_m));
}

TEST(SampledAxis, SmallStiffnessNeedsNoRenderedDampingOnADampedDevice) {
  const std::optional<DampingRange> range = StableDamping(Axis(1.5, 5.0, 1e-3, 2.8e-3), 500.0);
  ASSERT_TRUE(range);
  EXPECT_EQ(range->least_N_s_per_m, 0.0);
}

// m 0.5 to 5 kg, b 0 to 10 N s/m, T 0.25 and 1 ms, delay 0 to 10 ms in whole and broken periods, B over its stable
// range.
TEST(SampledAxis, ASimulatedWallIsStableBelowTheBoundaryAndUnstableAboveWithinOnePercent) {
  int checked = 0;
  for (const double m : {0.5, 1.5, 5.0}) {
    for (const double b : {0.0, 2.0, 10.0}) {
      for (const double T : {0.25e-3, 1e-3}) {
        for (const double delay_s : {0.0, 0.4e-3, 1e-3, 2.8e-3, 5e-3, 10e-3}) {
          const SampledAxis axis = Axis(m, b, T, delay_s);
          const double most = StableDamping(axis, 1.0)->most_N_s_per_m;
          for (const double share : {0.1, 0.5, 0.85}) {
            const double B = share * most;
            const double K = MaxStiffness(axis, B);
            EXPECT_TRUE(Decays(axis, {0.99 * K, B})) << m << ' ' << b << ' ' << T << ' ' << delay_s << ' ' << share;
            EXPECT_FALSE(Decays(axis, {1.01 * K, B})) << m << ' ' << b << ' ' << T << ' ' << delay_s << ' ' << share;
            ++checked;
          }
        }
      }
    }
  }
  EXPECT_EQ(checked, 324);
}

TEST(SampledAxis, NoDampingIsStableBeyondTheLargest) {
  for (const double b : {0.0, 10.0, 200.0, 3000.0}) {
    for (const double delay_s : {0.0, 0.4e-3, 3e-3}) {
      const SampledAxis axis = Axis(1.5, b, 1e-3, delay_s);
      const std::optional<DampingRange> range = StableDamping(axis, 1000.0);
      ASSERT_TRUE(range) << b << ' ' << delay_s;
      EXPECT_TRUE(IsStable(axis, {1000.0, 0.999 * range->most_N_s_per_m})) << b << ' ' << delay_s;
      for (int i = 0; i < 80; ++i) {  // to 50 times the largest
        const double B = 1.001 * std::pow(1.05, i) * range->most_N_s_per_m;
        EXPECT_FALSE(IsStable(axis, {1000.0, B})) << b << ' ' << delay_s << ' ' << B;
      }
    }
  }
}

TEST(SampledAxis, TheLinearRuleIsTheBoundaryForSmallDampingAndTooHighBeyond) {
  const struct {
    double beta, ratio[3];  // exact / linear at d = 0, 1, 2
  } published[] = {
      {0.02, {0.98, 0.98, 0.97}}, {0.05, {0.95, 0.94, 0.93}}, {0.1, {0.90, 0.89, 0.85}}, {0.2, {0.82, 0.77, 0.70}}};
  for (const auto& p : published) {
    for (int d = 0; d <= 2; ++d) {
      const SampledAxis axis = Undamped(d);
      EXPECT_NEAR(MaxStiffness(axis, p.beta) / LinearStiffnessRule(axis, p.beta), p.ratio[d], 0.0085)
          << d << ' ' << p.beta;
    }
  }
  // b = 2, B = 30, 3 ms, with the hand's 6.45 N s/m: the rule's 10.99 kN/m.
  EXPECT_NEAR(LinearStiffnessRule(Axis(2.054, 8.45, 1e-3, 3e-3), 30.0), 10.99e3, 5.0);
}

TEST(SampledAxis, TheFastestDecayHasThePublishedGains) {
  const struct {
    double d, alpha, beta;
  } published[] = {{0, 0.07024, 0.40535},
                   {1, 0.01914, 0.21812},
                   {2, 0.00866, 0.14851},
                   {3, 0.00490, 0.11247},
                   {5, 0.00219, 0.07565}};
  for (const auto& p : published) {
    const Wall wall = FastestDecay(Undamped(p.d));
    EXPECT_NEAR(wall.stiffness_N_per_m, p.alpha, 6e-6) << p.d;
    EXPECT_NEAR(wall.damping_N_s_per_m, p.beta, 6e-6) << p.d;
  }
}

TEST(SampledAxis, TheFastestDecaySettlesWithoutOvershootAfterSixteenDelays) {
  for (const double d : {0.0, 1.0, 2.0, 3.0, 5.0}) {
    const SampledAxis axis = Axis(1.5, 0.0, 1e-3, d * 1e-3);
    const std::vector<double> x = Simulate(axis, FastestDecay(axis), 0.1, 400);
    const double depth = *std::max_element(x.begin(), x.end());
    const double overshoot = -*std::min_element(x.begin(), x.end());
    std::size_t settled = x.size();
    while (settled > 0 && std::abs(x[settled - 1]) <= 0.01 * depth) --settled;
    // From the first sample in the wall, which is number 1, to the last outside the 1 %.
    const double settling = static_cast<double>(settled - 1) - 1.0;
    const double t0 = d + 1.0;
    EXPECT_LT(overshoot, 0.01 * depth) << d;
    EXPECT_NEAR(settling, 16.0 * t0, 1.0) << d;
    EXPECT_NEAR(depth, 2.0 * 0.1 * t0 * 1e-3, 0.04 * depth) << d;
  }
}

TEST(SampledAxis, TheFastestDecayOfADampedDeviceWithABrokenDelayHasNoOvershootEither) {
  for (const double b : {0.0, 5.0, 20.0}) {
    const SampledAxis axis = Axis(1.5, b, 1e-3, 2.8e-3);
    const Wall wall = FastestDecay(axis);
    const std::vector<double> x = Simulate(axis, wall, 0.1, 400);
    EXPECT_LT(-*std::min_element(x.begin(), x.end()), 0.01 * *std::max_element(x.begin(), x.end())) << b;
  }
}

// m = 1.5 kg, t_d = 2.8 ms, by the continuous limit: 8.2 kN/m and 182 N s/m.
TEST(SampledAxis, TheFastestDecayOfTheSlowLoopIsThePublishedExample) {
  const Wall wall = FastestDecay(Axis(1.5, 0.0, 1e-3, 2.8e-3));
  EXPECT_NEAR(wall.stiffness_N_per_m, 8200.0, 0.01 * 8200.0);
  EXPECT_NEAR(wall.damping_N_s_per_m, 182.0, 0.03 * 182.0);
}

TEST(SampledAxis, ADelayBeyondTheTableIsComputedAsTheLongest) {
  EXPECT_EQ(MaxStiffness(Undamped(1e9), 0.001), MaxStiffness(Undamped(kMaxDelay_periods), 0.001));
}

}  // namespace
}  // namespace stability
