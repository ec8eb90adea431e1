#pragma once

#include <cstdint>
#include <vector>

#include "core/messages/trace.hpp"

namespace device_bridge {

struct LatencySummary {
  std::uint64_t n = 0;
  double mean_ms = 0, p50_ms = 0, p90_ms = 0, p99_ms = 0, p999_ms = 0, max_ms = 0;
};

// The bridge's own, independent measurement of the force loop: when each sample was taken and when the first command
// that echoes its id was written to the device. It uses this host's clock and the id only, never the stamps of others,
// so it can check the chain that the stamps give. Beside it the stamped traces are kept for the hop table. Memory is
// taken at construction; Sent and Written are real-time safe.
class EchoLog {
 public:
  enum class Chain { kDirect, kThroughPhysics };

  // `num_samples`: of all roles together, expected in the run; what is beyond is counted, not kept.
  EchoLog(std::size_t num_roles, std::size_t num_samples);

  void Sent(unsigned role_index, std::uint64_t sequence, std::int64_t sample_ns) noexcept;

  // A command with these traces was written to the device at write_ns. Only the first echo of an id counts.
  void Written(const core::Header& header, std::int64_t write_ns) noexcept;

  [[nodiscard]] LatencySummary Summary(Chain chain) const;
  [[nodiscard]] double mean_ms(Chain chain) const {  // real-time safe
    const Log& log = logs_[Index(chain)];
    return log.count == 0 ? 0.0 : log.sum_ns / static_cast<double>(log.count) * 1e-6;
  }
  [[nodiscard]] std::uint64_t num_unknown() const { return num_unknown_; }  // ids never sent or too long ago
  [[nodiscard]] std::uint64_t num_not_kept() const { return num_not_kept_; }

  // A stamped trace that came back, and what this log measured for it.
  struct Echo {
    core::Trace trace;
    std::int64_t echo_ns = 0;  // write minus sample, by this log
  };
  [[nodiscard]] const std::vector<Echo>& echoes(Chain chain) const { return logs_[Index(chain)].echoes; }

 private:
  static constexpr std::size_t kWindow = 1 << 14;  // samples that may be under way per role: 16 s
  struct Departure {
    std::uint64_t id = 0;
    std::int64_t sample_ns = 0;
    bool has_returned[2] = {false, false};
  };
  struct Log {
    std::vector<std::int64_t> latencies_ns;
    std::vector<Echo> echoes;
    std::size_t stride = 1;  // every how many echoes a stamped trace is kept
    std::uint64_t count = 0;
    double sum_ns = 0.0;
  };
  static std::size_t Index(Chain chain) { return chain == Chain::kDirect ? 0 : 1; }
  void Return(Chain chain, const core::Trace& trace, std::int64_t write_ns) noexcept;

  std::vector<std::vector<Departure>> departures_;  // per role, by sequence modulo kWindow
  Log logs_[2];
  std::uint64_t num_unknown_ = 0;
  std::uint64_t num_not_kept_ = 0;
};

}  // namespace device_bridge
