#pragma once

#include <cstdint>

#include "core/clock.hpp"

namespace bus {

struct TickInfo {
  std::uint64_t index = 0;        // of this tick since the first; misses included, so index * period is elapsed time
  std::int64_t scheduled_ns = 0;  // CLOCK_MONOTONIC
  std::int64_t woke_ns = 0;
  std::uint64_t skipped = 0;  // whole periods that passed before this call came: their ticks are gone
};

// Ticks at absolute times, so that lateness does not add up: tick k is due at start + k * period.
//   PeriodicLoop loop(core::kTick_ns);
//   while (running) { const TickInfo tick = loop.WaitNext(); ... }
class PeriodicLoop {
 public:
  explicit PeriodicLoop(std::int64_t period_ns, std::int64_t start_ns = core::MonotonicNow_ns());

  // Sleeps until the next tick is due (clock_nanosleep, absolute). Late by whole periods: skips them and counts.
  TickInfo WaitNext();
  // For callers that wait by other means, e.g. Node::Wait(next_due_ns()): does not sleep.
  [[nodiscard]] std::int64_t next_due_ns() const { return next_ns_; }
  TickInfo Advance(std::int64_t now_ns);

  [[nodiscard]] std::int64_t period_ns() const { return period_ns_; }
  [[nodiscard]] std::uint64_t ticks() const { return ticks_; }
  [[nodiscard]] std::uint64_t skipped() const { return skipped_; }
  [[nodiscard]] std::int64_t max_wake_delay_ns() const { return max_wake_delay_ns_; }

 private:
  std::int64_t period_ns_;
  std::int64_t next_ns_;
  std::uint64_t next_index_ = 0;
  std::uint64_t ticks_ = 0;
  std::uint64_t skipped_ = 0;
  std::int64_t max_wake_delay_ns_ = 0;
};

}  // namespace bus
