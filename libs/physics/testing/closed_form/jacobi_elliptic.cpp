#include "physics/testing/closed_form/jacobi_elliptic.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace physics::closed_form {
namespace {

// a_0 = 1, b_0 = k', c_0 = k; a' = (a + b) / 2, b' = sqrt(a b), c' = (a - b) / 2. Converges quadratically: eight steps
// reach rounding even for k' = 1e-12.
struct Mean {
  static constexpr int kSteps = 10;
  std::array<double, kSteps + 1> a{};
  std::array<double, kSteps + 1> b{};
  std::array<double, kSteps + 1> c{};

  explicit Mean(double complement) {
    a[0] = 1.0;
    b[0] = complement;
    c[0] = std::sqrt((1.0 - complement) * (1.0 + complement));
    for (std::size_t i = 0; i < kSteps; ++i) {
      a[i + 1] = 0.5 * (a[i] + b[i]);
      b[i + 1] = std::sqrt(a[i] * b[i]);
      c[i + 1] = 0.5 * (a[i] - b[i]);
    }
  }
};

}  // namespace

JacobiElliptic EvaluateJacobi(double u, double complementary_modulus) {
  const Mean mean(complementary_modulus);
  // phi_N = 2^N a_N u, then downwards sin(2 phi_{n-1} - phi_n) = c_n / a_n sin phi_n.
  double phi = std::ldexp(mean.a[Mean::kSteps] * u, Mean::kSteps);
  for (std::size_t n = Mean::kSteps; n > 0; --n) {
    phi = 0.5 * (phi + std::asin(std::clamp(mean.c[n] / mean.a[n] * std::sin(phi), -1.0, 1.0)));
  }
  JacobiElliptic f;
  f.sn = std::sin(phi);
  f.cn = std::cos(phi);
  // dn^2 = 1 - k^2 sn^2 = k'^2 + k^2 cn^2: no cancellation.
  f.dn = std::hypot(complementary_modulus, mean.c[0] * f.cn);
  return f;
}

double CompleteEllipticK(double complementary_modulus) {
  return 0.5 * std::numbers::pi / Mean(complementary_modulus).a[Mean::kSteps];
}

double IncompleteEllipticF(double phi_rad, double complementary_modulus) {
  // F(phi + n pi) = F(phi) + 2 n K: the remainder lies in [-pi / 2, pi / 2].
  const double turns = std::round(phi_rad / std::numbers::pi);
  double phi = phi_rad - turns * std::numbers::pi;
  const Mean mean(complementary_modulus);
  // tan(phi_{n+1} - phi_n) = b_n / a_n tan phi_n with phi_{n+1} - phi_n on the branch of phi_n;
  // F = phi_N / (2^N a_N).
  for (std::size_t n = 0; n < Mean::kSteps; ++n) {
    const double branch = std::round(phi / std::numbers::pi);
    const double rest = phi - branch * std::numbers::pi;
    const double turned = std::atan2(mean.b[n] * std::sin(rest), mean.a[n] * std::cos(rest));
    phi += branch * std::numbers::pi + turned;
  }
  const double remainder = std::ldexp(phi / mean.a[Mean::kSteps], -Mean::kSteps);
  return remainder + 2.0 * turns * CompleteEllipticK(complementary_modulus);
}

}  // namespace physics::closed_form
