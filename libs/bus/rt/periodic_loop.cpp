#include "bus/rt/periodic_loop.hpp"

#include <algorithm>
#include <cerrno>
#include <ctime>

namespace bus {

PeriodicLoop::PeriodicLoop(std::int64_t period_ns, std::int64_t start_ns) : period_ns_(period_ns), next_ns_(start_ns) {}

TickInfo PeriodicLoop::WaitNext() {
  timespec due{};
  due.tv_sec = static_cast<time_t>(next_ns_ / core::kNanosecondsPerSecond);
  due.tv_nsec = static_cast<long>(next_ns_ % core::kNanosecondsPerSecond);
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr) == EINTR) {
  }
  return Advance(core::MonotonicNow_ns());
}

TickInfo PeriodicLoop::Advance(std::int64_t now_ns) {
  TickInfo tick;
  tick.woke_ns = now_ns;
  if (now_ns >= next_ns_ + period_ns_) {
    tick.skipped = static_cast<std::uint64_t>((now_ns - next_ns_) / period_ns_);
    next_ns_ += static_cast<std::int64_t>(tick.skipped) * period_ns_;
    next_index_ += tick.skipped;
    skipped_ += tick.skipped;
  }
  tick.index = next_index_;
  tick.scheduled_ns = next_ns_;
  max_wake_delay_ns_ = std::max(max_wake_delay_ns_, now_ns - next_ns_);
  next_ns_ += period_ns_;
  ++next_index_;
  ++ticks_;
  return tick;
}

}  // namespace bus
