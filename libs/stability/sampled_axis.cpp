#include "stability/sampled_axis.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "stability/schur_cohn.hpp"

namespace stability {
namespace {

constexpr int kBisections = 48;  // leave 4e-15 of the first interval
// Below this (beta + delta) (d + 1) the boundary is its tangent to 1e-4, and the polynomial's roots are too close to 1
// for the test's rounding.
constexpr double kTangent = 1e-4;
constexpr double kLeastShare = 1e-6;  // of the linear rule: a smaller largest K counts as none

// The axis with T = m = 1. Its position response to F is N(z) / (z^(n+1) (z - 1) (z - E)), N of degree 2.
struct Normalised {
  double delta = 0.0;
  double d = 0.0;
  int n = 0;  // whole periods of the delay
  double E = 1.0;
  std::array<double, 3> N{};  // coefficients of 1, z, z^2
};

// Way and speed after a unit force on a unit mass has acted for `s`, from rest:
//   x = (delta s - 1 + e^(-delta s)) / delta^2,   v = (1 - e^(-delta s)) / delta.
struct Response {
  double x = 0.0;
  double v = 0.0;
};
Response UnitForce(double delta, double s) noexcept {
  // Below 1e-3 the closed form loses digits; the series' next term is below 1e-18.
  if (delta * s < 1e-3) {
    const double u = delta * s;
    return {s * s * (0.5 - u / 6.0 + u * u / 24.0 - u * u * u / 120.0 + u * u * u * u / 720.0),
            s * (1.0 - u / 2.0 + u * u / 6.0 - u * u * u / 24.0 + u * u * u * u / 120.0)};
  }
  return {(delta * s + std::expm1(-delta * s)) / (delta * delta), -std::expm1(-delta * s) / delta};
}

Normalised Normalise(const SampledAxis& axis) noexcept {
  Normalised a;
  a.delta = axis.damping_N_s_per_m * axis.period_s / axis.mass_kg;
  a.d = std::clamp(axis.delay_s / axis.period_s, 0.0, static_cast<double>(kMaxDelay_periods));
  a.n = static_cast<int>(a.d);
  a.E = std::exp(-a.delta);
  const double f = a.d - a.n;
  const double free_way = UnitForce(a.delta, 1.0).v;  // in one period at unit speed
  // In each period the older force acts for f and coasts for 1 - f; then the newer one acts for 1 - f.
  const Response newer = UnitForce(a.delta, 1.0 - f);
  const Response older = UnitForce(a.delta, f);
  const double older_x = older.x + UnitForce(a.delta, 1.0 - f).v * older.v;
  const double older_v = older.v * std::exp(-a.delta * (1.0 - f));
  a.N = {free_way * older_v - a.E * older_x, older_x - a.E * newer.x + free_way * newer.v, newer.x};
  return a;
}

bool IsStable(const Normalised& a, double alpha, double beta) noexcept {
  std::array<double, kMaxDelay_periods + 5> c{};
  const auto n = static_cast<std::size_t>(a.n);
  c[n + 2] += a.E;
  c[n + 3] -= 1.0 + a.E;
  c[n + 4] += 1.0;
  for (std::size_t i = 0; i < 3; ++i) {
    c[i] -= beta * a.N[i];
    c[i + 1] += (alpha + beta) * a.N[i];
  }
  return AreRootsInsideUnitCircle({c.data(), n + 5});
}

// The border between `stable` and `unstable` of a one-parameter test.
template <class Test>
double Bisect(double stable, double unstable, const Test& is_stable) noexcept {
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (stable + unstable);
    (is_stable(middle) ? stable : unstable) = middle;
  }
  return stable;
}

double MaxAlpha(const Normalised& a, double beta) noexcept {
  const auto is_stable = [&](double alpha) { return IsStable(a, alpha, beta); };
  const double linear = (beta + a.delta) / (a.d + 0.5);
  if ((beta + a.delta) * (a.d + 1.0) < kTangent) return std::max(linear, 0.0);
  double stable = linear;
  while (!is_stable(stable)) {
    stable *= 0.5;
    if (!(stable > kLeastShare * linear)) return 0.0;
  }
  double unstable = 2.0 * stable;
  while (is_stable(unstable)) {
    stable = unstable;
    unstable *= 2.0;
  }
  return Bisect(stable, unstable, is_stable);
}

// A beta that is stable with no alpha. Without damping the largest stable one is 2 tan(pi / (4 (d + 1))).
double AboveMaxBeta(const Normalised& a) noexcept {
  double beta = 2.2 * std::tan(M_PI / (4.0 * (a.d + 1.0))) + 2.0 * a.delta;
  while (MaxAlpha(a, beta) > 0.0) beta *= 2.0;
  return beta;
}

struct Point {
  double alpha = 0.0;
  double beta = 0.0;
};

// The boundary over beta has one maximum: golden section.
Point Peak(const Normalised& a) noexcept {
  constexpr double kGolden = 0.618033988749894848;
  double low = 0.0;
  double high = AboveMaxBeta(a);
  double left = high - kGolden * (high - low);
  double right = low + kGolden * (high - low);
  double alpha_left = MaxAlpha(a, left);
  double alpha_right = MaxAlpha(a, right);
  while (high - low > 1e-7 * high) {
    if (alpha_left > alpha_right) {
      high = right;
      right = left;
      alpha_right = alpha_left;
      left = high - kGolden * (high - low);
      alpha_left = MaxAlpha(a, left);
    } else {
      low = left;
      left = right;
      alpha_left = alpha_right;
      right = low + kGolden * (high - low);
      alpha_right = MaxAlpha(a, right);
    }
  }
  return {std::max(alpha_left, alpha_right), 0.5 * (low + high)};
}

Wall Scale(const SampledAxis& axis, const Point& point) noexcept {
  return {point.alpha * axis.mass_kg / (axis.period_s * axis.period_s), point.beta * axis.mass_kg / axis.period_s};
}

// g(z) = -z^(n+2) (z - 1) (z - E) / N(z) with its first two derivatives. On the characteristic equation
// g(z) = (alpha + beta) z - beta, so a pole is double where g' = alpha + beta, and triple where g'' = 0, too.
struct Curve {
  double value = 0.0;
  double slope = 0.0;
  double curvature = 0.0;
};
Curve CurveAt(const Normalised& a, double z) noexcept {
  const double power = std::pow(z, a.n);
  const auto q = static_cast<double>(a.n + 2);
  // P = z^(n+2), Q = (z - 1) (z - E), D = P Q
  const double P0 = power * z * z;
  const double P1 = q * power * z;
  const double P2 = q * (q - 1.0) * power;
  const double Q0 = (z - 1.0) * (z - a.E);
  const double Q1 = 2.0 * z - 1.0 - a.E;
  const double PQ0 = P0 * Q0;
  const double PQ1 = P1 * Q0 + P0 * Q1;
  const double PQ2 = P2 * Q0 + 2.0 * P1 * Q1 + 2.0 * P0;
  const double N0 = a.N[0] + z * (a.N[1] + z * a.N[2]);
  const double N1 = a.N[1] + 2.0 * z * a.N[2];
  const double N2 = 2.0 * a.N[2];
  const double r0 = PQ0 / N0;
  const double r1 = (PQ1 - r0 * N1) / N0;
  const double r2 = (PQ2 - 2.0 * r1 * N1 - r0 * N2) / N0;
  return {-r0, -r1, -r2};
}

}  // namespace

bool IsStable(const SampledAxis& axis, const Wall& wall) noexcept {
  const double T = axis.period_s;
  return IsStable(Normalise(axis), wall.stiffness_N_per_m * T * T / axis.mass_kg,
                  wall.damping_N_s_per_m * T / axis.mass_kg);
}

double MaxStiffness(const SampledAxis& axis, double damping_N_s_per_m) noexcept {
  const double beta = damping_N_s_per_m * axis.period_s / axis.mass_kg;
  return Scale(axis, {MaxAlpha(Normalise(axis), beta), beta}).stiffness_N_per_m;
}

Wall StiffestWall(const SampledAxis& axis) noexcept {
  return Scale(axis, Peak(Normalise(axis)));
}

std::optional<DampingRange> StableDamping(const SampledAxis& axis, double stiffness_N_per_m) noexcept {
  const Normalised a = Normalise(axis);
  const double alpha = stiffness_N_per_m * axis.period_s * axis.period_s / axis.mass_kg;
  const auto is_stable = [&](double beta) { return IsStable(a, alpha, beta); };
  const Point peak = Peak(a);
  if (!is_stable(peak.beta)) return std::nullopt;
  const double least = is_stable(0.0) ? 0.0 : Bisect(peak.beta, 0.0, is_stable);
  const double most = Bisect(peak.beta, AboveMaxBeta(a), is_stable);
  const double unit = axis.mass_kg / axis.period_s;
  return DampingRange{least * unit, most * unit};
}

double MaxDamping(const SampledAxis& axis, const Wall& wall) noexcept {
  const Normalised a = Normalise(axis);
  const double unit = axis.mass_kg / axis.period_s;
  const double alpha = wall.stiffness_N_per_m * axis.period_s / unit;
  const auto is_stable = [&](double beta) { return IsStable(a, alpha, beta); };
  double stable = wall.damping_N_s_per_m / unit;
  if (!is_stable(stable)) return 0.0;
  double unstable = stable + 0.1 / (a.d + 1.0);
  while (is_stable(unstable)) {
    stable = unstable;
    unstable *= 1.5;
  }
  return unit * Bisect(stable, unstable, is_stable);
}

double LinearStiffnessRule(const SampledAxis& axis, double damping_N_s_per_m) noexcept {
  return (axis.damping_N_s_per_m + damping_N_s_per_m) / (0.5 * axis.period_s + axis.delay_s);
}

Wall FastestDecay(const SampledAxis& axis) noexcept {
  const Normalised a = Normalise(axis);
  // The triple pole nearest to 1 is near exp(-0.586 / (d + 1)); g'' is negative between it and 1.
  const double step = 0.01 / (a.d + 1.0);
  double above = 1.0;
  while (above > step && CurveAt(a, above - step).curvature < 0.0) above -= step;
  const double pole = Bisect(above, above - step, [&](double z) { return CurveAt(a, z).curvature < 0.0; });
  const Curve g = CurveAt(a, pole);
  const double beta = pole * g.slope - g.value;
  return Scale(axis, {g.slope - beta, beta});
}

}  // namespace stability
