#include "tools/oos/launch/clock_series.hpp"

#include <cstdlib>

#include "core/clock.hpp"

namespace oos {

core::Result<ClockSeries> ClockSeries::Open(Remotes* remotes, std::size_t host, const std::string& oos) {
  ClockSeries series;
  auto child = remotes->Open(host, oos + " clock");
  if (!child) return tl::unexpected(child.error());
  series.child_ = std::move(*child);
  return series;
}

std::optional<ClockReading> ClockSeries::Read(int num_readings, int patience_ms) {
  std::optional<ClockReading> best;
  child_->Poll();
  child_->TakeLines();  // answers that came too late
  const std::int64_t deadline_ns = core::MonotonicNow_ns() + patience_ms * std::int64_t{1'000'000};
  for (int i = 0; i < num_readings; ++i) {
    const std::int64_t t0_ns = core::MonotonicNow_ns();
    child_->Write("\n");
    std::vector<std::string> lines;
    while (lines.empty()) {
      if (child_->has_ended() || core::MonotonicNow_ns() > deadline_ns) return best;
      WaitForAny({child_.get()}, 5);
      child_->Poll();
      lines = child_->TakeLines();
    }
    const std::int64_t t1_ns = core::MonotonicNow_ns();
    const std::int64_t there_ns = std::strtoll(lines.back().c_str(), nullptr, 10);
    const ClockReading reading = {t1_ns, there_ns - (t0_ns + (t1_ns - t0_ns) / 2), (t1_ns - t0_ns + 1) / 2};
    if (!best || reading.bound_ns < best->bound_ns) best = reading;
  }
  return best;
}

}  // namespace oos
