#pragma once

namespace device_bridge {

// Mass on a spring and a damper: m y'' + c y' + k y = f, with f constant over a step.
struct Oscillator {
  double mass = 1.0;       // kg or kg m2, > 0
  double damping = 0.0;    // N s/m or Nm s/rad, >= 0
  double stiffness = 0.0;  // N/m or Nm/rad, >= 0
};

struct OscillatorState {
  double position = 0.0;
  double velocity = 0.0;
};

// State after dt_s under a constant force [N or Nm]: the exact zero-order-hold solution, hence stable for any stiffness
// and step length. Accurate to rounding in every regime (free, pure damper, under-, over- and critically damped).
OscillatorState StepExactly(const Oscillator& axis, const OscillatorState& state, double force, double dt_s);

}  // namespace device_bridge
