#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bus/log/mcap_writer.hpp"
#include "bus/log/tap.hpp"

namespace bus::log {

// The channel "clock/<node>" of a recording: offset, bound and drift of the peers' clocks, every kPeriod_ns.
class ClockChannel {
 public:
  static constexpr std::int64_t kPeriod_ns = 500'000'000;  // drift within it stays below 0.25 ms (kMaxDrift)

  [[nodiscard]] bool is_due(std::int64_t now_ns) const { return now_ns - written_ns_ >= kPeriod_ns; }

  core::Result<void> Write(const std::string& node, const std::vector<PeerClock>& clocks, std::int64_t now_ns,
                           McapWriter* to);

  // Starts in another file.
  void BeginFile() { channel_.reset(); }

 private:
  std::optional<std::uint16_t> channel_;
  std::uint32_t num_samples_ = 0;
  std::int64_t written_ns_ = 0;
};

}  // namespace bus::log
