#pragma once

#include <cstdint>

#include "physics/checkpoint.hpp"

namespace physics {

// When a figure of a mechanism takes its new value.
//   kAtOnce         in the next step, all of it.
//   kRamped         linearly over `ramp_s`, a part at the top of each step.
//   kWhenSeparated  held until the change gives the mechanism no energy: it does not act, or is where it stores none.
enum class ChangeMode : std::uint8_t { kAtOnce, kRamped, kWhenSeparated };

struct Change {
  double value = 0.0;  // SI, as the mechanism's Params; a lock is 0 or 1
  ChangeMode mode = ChangeMode::kAtOnce;
  double ramp_s = 0.0;
};

// What a change has done so far. Springs that are deflected by x hold k x^2 / 2, so that a change of k gives
// (k' - k) x^2 / 2 to the scene; `injected_J` is the mechanism's stored energy with the new value less that with the
// old one at the same poses, summed over a ramp. Negative when it took energy out. Damping, locks and motors store
// none.
struct ChangeReport {
  std::uint64_t first_tick = 0;  // the first step that runs with another value; 0: held until now
  std::uint64_t last_tick = 0;   // the first step that runs with the wanted value; 0: not yet
  double injected_J = 0.0;
};

// A figure of a mechanism that can be changed while the world runs, and the change that is under way.
struct Tunable {
  const char* name = nullptr;  // as the parameter's in scenarios/README.md, after "<mechanism>."
  double* value = nullptr;
  bool is_signed = false;  // else it must not be negative

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
