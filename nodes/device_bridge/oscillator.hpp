#pragma once

namespace device_bridge {

// One axis m y'' + c y' + k y = f with f constant over a step: a mass on a spring and a damper.
struct Oscillator {
  double mass = 1.0;       // kg or kg m2, > 0
  double damping = 0.0;    // N s/m or Nm s/rad, >= 0
  double stiffness = 0.0;  // N/m or Nm/rad, >= 0
};

struct OscillatorState {
  double position = 0.0;
  double velocity = 0.0;
};

// State after dt_s under the constant force: the exact zero-order-hold solution, not an integration, so it is stable
// at any stiffness and any step length. Accurate to rounding in every regime (free, pure damper, under-, over- and
// critically damped).
OscillatorState StepExactly(const Oscillator& axis, const OscillatorState& state, double force, double dt_s);

}  // namespace device_bridge
