#pragma once

#include <cstdint>

#include "physics/checkpoint.hpp"

namespace physics {

// When a mechanism's value changes.
//   kAtOnce         in the next step.
//   kRamped         linearly over `ramp_s`, at the start of each step.
//   kWhenSeparated  held until the change injects no energy: the mechanism does not act, or stores none at its pose.
enum class ChangeMode : std::uint8_t { kAtOnce, kRamped, kWhenSeparated };

struct Change {
  double value = 0.0;  // SI, as the mechanism's Params; a lock is 0 or 1
  ChangeMode mode = ChangeMode::kAtOnce;
  double ramp_s = 0.0;
};

// State of a change. `injected_J` is the mechanism's stored energy with the new value minus that with the old one at
// the same poses, summed over a ramp: (k' - k) x^2 / 2 for a spring with deflection x. It is negative when energy is
// removed. Damping, locks and motors store none.
struct ChangeReport {
  std::uint64_t first_tick = 0;  // the first step with a changed value; 0: held until now
  std::uint64_t last_tick = 0;   // the first step with the final value; 0: not yet
  double injected_J = 0.0;
};

// A value of a mechanism that can be changed at run time, and its change in progress.
struct Tunable {
  const char* name = nullptr;  // name of the parameter in scenarios/README.md, after "<mechanism>."
  double* value = nullptr;
  bool is_signed = false;  // false: must not be negative

  struct State {
    bool is_pending = false;
    Change change;
    double start_value = 0.0;
    double elapsed_s = 0.0;
    ChangeReport report;
  } state;

  void ExchangeState(Checkpoint* checkpoint) {
    checkpoint->Exchange(value);
    checkpoint->Exchange(&state);
  }
};

}  // namespace physics
