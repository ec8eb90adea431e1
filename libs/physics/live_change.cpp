#include "physics/live_change.hpp"

#include <algorithm>
#include <cmath>

#include "physics/row.hpp"

namespace physics {
namespace {

// A held change is applied when it injects less energy than this, that of a spring of 20 kN/m deflected by 0.3 um.
// Chosen: far below any energy of interest, above the residual deflection of a part at rest.
constexpr double kNoEnergy_J = 1e-9;

}  // namespace

void Mechanism::SetValue(Tunable* tunable, double value, const BodyView& parent, const BodyView& child,
                         std::uint64_t tick) {
  ChangeReport& report = tunable->state.report;
  const double before_J = StoredEnergy_J(parent, child);
  *tunable->value = value;
  report.injected_J += StoredEnergy_J(parent, child) - before_J;
  if (report.first_tick == 0) report.first_tick = tick;
  if (value != tunable->state.change.value) return;
  report.last_tick = tick;
  tunable->state.is_pending = false;
}

const ChangeReport& Mechanism::BeginChange(std::size_t index, const Change& change, const BodyView& parent,
                                           const BodyView& child, std::uint64_t next_tick) {
  Tunable& tunable = tunables_[index];
  tunable.state = {true, change, *tunable.value, 0.0, {}};
  if (change.mode == ChangeMode::kAtOnce) SetValue(&tunable, change.value, parent, child, next_tick);
  return tunable.state.report;
}

void Mechanism::AdvanceChanges(const BodyView& parent, const BodyView& child, std::uint64_t tick, double dt_s) {
  for (Tunable& tunable : tunables_) {
    Tunable::State& state = tunable.state;
    if (!state.is_pending) continue;
    if (state.change.mode == ChangeMode::kRamped) {
      state.elapsed_s += dt_s;
      const bool is_over = state.elapsed_s >= state.change.ramp_s - 0.5 * dt_s;
      const double part = state.elapsed_s / std::max(state.change.ramp_s, dt_s);
      const double value =
          is_over ? state.change.value : state.start_value + part * (state.change.value - state.start_value);
      SetValue(&tunable, value, parent, child, tick);
      continue;
    }
    const double old_value = *tunable.value;
    const double before_J = StoredEnergy_J(parent, child);
    *tunable.value = state.change.value;
    const double injected_J = StoredEnergy_J(parent, child) - before_J;
    *tunable.value = old_value;
    if (std::abs(injected_J) <= kNoEnergy_J) SetValue(&tunable, state.change.value, parent, child, tick);
  }
}

}  // namespace physics
