#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/messages/trace.hpp"

namespace device_bridge {

struct LatencySummary {
  std::uint64_t n = 0;
  double mean_ms = 0, p50_ms = 0, p90_ms = 0, p99_ms = 0, p999_ms = 0, max_ms = 0;
};

// Measures the latency of the force loop independently of stamps: from the time of each sample to the time at which the
// first command that echoes its trace id was written to the device. It uses only this host's clock and the id, so it
// can verify the latencies that the stamps give. It also keeps stamped traces for the hop table. Memory is allocated at
// construction; RecordSample and RecordWrite are real-time safe.
class EchoLog {
 public:
  enum class Chain { kDirect, kThroughPhysics };

  // `num_samples`: capacity for all roles together; further samples are counted but not kept.
  EchoLog(std::size_t num_roles, std::size_t num_samples);

  void RecordSample(unsigned role_index, std::uint64_t sequence, std::int64_t sample_ns) noexcept;

  // A command with these traces was written to the device at write_ns. Only the first echo of an id counts. Returns the
  // latency of the direct loop when this was one.
  std::optional<std::int64_t> RecordWrite(const core::Header& header, std::int64_t write_ns) noexcept;

  [[nodiscard]] LatencySummary Summary(Chain chain) const;
  [[nodiscard]] double mean_ms(Chain chain) const {  // real-time safe
    const Log& log = logs_[Index(chain)];
    return log.count == 0 ? 0.0 : log.sum_ns / static_cast<double>(log.count) * 1e-6;
  }
  [[nodiscard]] std::uint64_t num_unknown() const { return num_unknown_; }  // echoes of ids never sent, or too old
  [[nodiscard]] std::uint64_t num_not_kept() const { return num_not_kept_; }

  // A stamped trace that returned, and this log's latency for it.
  struct Echo {
    core::Trace trace;
    std::int64_t echo_ns = 0;  // write minus sample, by this log
  };
  [[nodiscard]] const std::vector<Echo>& echoes(Chain chain) const { return logs_[Index(chain)].echoes; }

 private:
  static constexpr std::size_t kWindow = 1
                                         << 14;  // samples in flight per role: 16 s at 1 kHz, far above any echo's age
  struct Departure {
    std::uint64_t id = 0;
    std::int64_t sample_ns = 0;
    bool has_returned[2] = {false, false};
  };
  struct Log {
    std::vector<std::int64_t> latencies_ns;
    std::vector<Echo> echoes;
    std::size_t stride = 1;  // keeps the stamped trace of one echo in `stride`
    std::uint64_t count = 0;
    double sum_ns = 0.0;
  };
  static std::size_t Index(Chain chain) { return chain == Chain::kDirect ? 0 : 1; }
  std::optional<std::int64_t> RecordEcho(Chain chain, const core::Trace& trace, std::int64_t write_ns) noexcept;

  std::vector<std::vector<Departure>> departures_;  // per role, by sequence modulo kWindow
  Log logs_[2];
  std::uint64_t num_unknown_ = 0;
  std::uint64_t num_not_kept_ = 0;
};

}  // namespace device_bridge
