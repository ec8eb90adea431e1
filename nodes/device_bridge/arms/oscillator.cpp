#include "nodes/device_bridge/arms/oscillator.hpp"

#include <cmath>

namespace device_bridge {
namespace {

// With a = c / (2 m) [1/s] and w = k / m [1/s^2] the equation is y'' + 2a y' + w y = f/m. For constant f its solution
// is linear in the state and in the acceleration f/m:
//   y(t)  = p00 y0 + p01 y0' + g (f/m)
//   y'(t) = p10 y0 + p11 y0' + p01 (f/m)
// with the impulse response p01, its integral g, p10 = -w p01, p11 = p01' and p00 = 1 - w g.
struct Propagator {
  double p01 = 0.0;
  double p11 = 0.0;
  double g = 0.0;
};

// Taylor series of the impulse response h(t): h'' = -2a h' - w h, h(0) = 0, h'(0) = 1. It divides neither by k nor c
// nor the difference of the roots, so it covers every degenerate case. For |root| t < 0.3 the 18 terms reach rounding:
// the remainder is about 0.3^18 / 18! < 1e-25 of the first term.
Propagator SeriesPropagator(double two_a, double w, double t) {
  // h = sum h_n t^n with (n+2)(n+1) h_{n+2} = -2a (n+1) h_{n+1} - w h_n; terms carry their power of t.
  Propagator p;
  double previous = 0.0;  // h_n t^n
  double current = t;     // h_{n+1} t^{n+1}
  for (int n = 0; n < 18; ++n) {
    p.p01 += current;
    p.p11 += (n + 1) * current / t;
    p.g += current * t / (n + 2);
    const double next = (-two_a * t * (n + 1) * current - w * t * t * previous) / ((n + 2.0) * (n + 1.0));
    previous = current;
    current = next;
  }
  return p;
}

// By the roots of s^2 + 2a s + w, s = -a +- r with r = sqrt|a^2 - w| (times i when underdamped):
//   underdamped:  p01 = e^(-a t) sin(r t) / r,   near critical:  p01 = e^(-a t) sinh(r t) / r,
//   overdamped:   p01 = (e^(s1 t) - e^(s2 t)) / (s1 - s2).
Propagator ClosedFormPropagator(double a, double w, double t) {
  Propagator p;
  const double discriminant = a * a - w;
  const double root = std::sqrt(std::abs(discriminant));
  if (discriminant < 0.0) {  // underdamped
    const double decay = std::exp(-a * t);
    const double sine = std::sin(root * t) / root;
    const double cosine = std::cos(root * t);
    p.p01 = decay * sine;
    p.p11 = decay * (cosine - a * sine);
    p.g = (1.0 - decay * (cosine + a * sine)) / w;
    return p;
  }
  if (root * t < 0.1) {  // near critical: sinh(r t) / r -> t, which avoids the difference of nearly equal exponentials
    const double decay = std::exp(-a * t);
    const double x = root * t;
    const double sinhc = x < 1e-4 ? t * (1.0 + x * x / 6.0) : std::sinh(x) / root;
    const double cosh = std::cosh(x);
    p.p01 = decay * sinhc;
    p.p11 = decay * (cosh - a * sinhc);
    p.g = (1.0 - decay * (cosh + a * sinhc)) / w;
    return p;
  }
  // The product of the roots is w, so s1 = w / s2 loses no digits when w is small.
  const double fast = -(a + root);
  const double slow = w / fast;
  const double gap = slow - fast;
  p.p01 = (std::exp(slow * t) - std::exp(fast * t)) / gap;
  p.p11 = (slow * std::exp(slow * t) - fast * std::exp(fast * t)) / gap;
  // g is the integral of p01; its first term tends to t for s1 -> 0.
  const double slow_part = std::abs(slow * t) < 1e-12 ? t : std::expm1(slow * t) / slow;
  p.g = (slow_part - std::expm1(fast * t) / fast) / gap;
  return p;
}

}  // namespace

OscillatorState StepExactly(const Oscillator& axis, const OscillatorState& state, double force, double dt_s) {
  if (dt_s <= 0.0) return state;
  const double w = axis.stiffness / axis.mass;
  const double a = 0.5 * axis.damping / axis.mass;
  const double fastest_root = a * a > w ? a + std::sqrt(a * a - w) : std::sqrt(w);
  const Propagator p =
      fastest_root * dt_s < 0.3 ? SeriesPropagator(2.0 * a, w, dt_s) : ClosedFormPropagator(a, w, dt_s);
  const double acceleration = force / axis.mass;
  return {(1.0 - w * p.g) * state.position + p.p01 * state.velocity + p.g * acceleration,
          -w * p.p01 * state.position + p.p11 * state.velocity + p.p01 * acceleration};
}

}  // namespace device_bridge
