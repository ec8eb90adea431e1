#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>

#include "tools/oos/attach/remote.hpp"

namespace oos {

// How far another machine's CLOCK_MONOTONIC is ahead of ours: the true value is within the bound.
struct ClockReading {
  std::int64_t time_ns = 0;  // ours
  std::int64_t offset_ns = 0;
  std::int64_t bound_ns = 0;
};

// Reads the clock of a host by `oos clock`. Our clock is read before the request and after the answer (t0, t1), the
// host's in between (h): h = t + offset for a t in [t0, t1], so offset = h - (t0 + t1) / 2 within +- (t1 - t0) / 2
// [Cristian 1989].
class ClockSeries {
 public:
  static core::Result<ClockSeries> Open(Remotes* remotes, std::size_t host, const std::string& oos);

  // The reading with the smallest bound of `num_readings`; none if the host is silent for `patience_ms`.
  std::optional<ClockReading> Read(int num_readings, int patience_ms);

 private:
  std::unique_ptr<PipedChild> child_;
};

}  // namespace oos
