#include "muscle/biquad.hpp"

#include <cmath>
#include <glm/gtc/constants.hpp>

namespace muscle {
namespace {

constexpr double kSqrt2 = 1.4142135623730951;

}  // namespace

// With s = (1 - z^-1) / (K (1 + z^-1)), K = tan(pi f T), in 1 / (s^2 + sqrt(2) s + 1), or s^2 above it.
Biquad Biquad::LowPass(double corner_Hz, double sample_s) {
  const double k = std::tan(glm::pi<double>() * corner_Hz * sample_s);
  const double norm = 1.0 / (1.0 + kSqrt2 * k + k * k);
  Biquad filter;
  filter.b0_ = filter.b2_ = k * k * norm;
  filter.b1_ = 2.0 * filter.b0_;
  filter.a1_ = 2.0 * (k * k - 1.0) * norm;
  filter.a2_ = (1.0 - kSqrt2 * k + k * k) * norm;
  return filter;
}

Biquad Biquad::HighPass(double corner_Hz, double sample_s) {
  const double k = std::tan(glm::pi<double>() * corner_Hz * sample_s);
  Biquad filter = LowPass(corner_Hz, sample_s);
  const double norm = 1.0 / (1.0 + kSqrt2 * k + k * k);
  filter.b0_ = filter.b2_ = norm;
  filter.b1_ = -2.0 * norm;
  return filter;
}

}  // namespace muscle
