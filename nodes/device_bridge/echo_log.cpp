#include "nodes/device_bridge/echo_log.hpp"

#include <algorithm>
#include <cmath>

namespace device_bridge {
namespace {

// Every sample returns by the direct chain; one in four of its stamped traces suffices for the percentiles of the hop
// table. Both values bound memory and file size; they are chosen, not measured.
constexpr std::size_t kDirectStride = 4;
constexpr std::size_t kMaxEchoes = 65536;

}  // namespace

EchoLog::EchoLog(std::size_t num_roles, std::size_t num_samples) {
  departures_.resize(num_roles);
  for (auto& role : departures_) role.resize(kWindow);
  for (Log& log : logs_) log.latencies_ns.reserve(num_samples);
  logs_[0].stride = kDirectStride;
  logs_[0].echoes.reserve(std::min(num_samples / kDirectStride + 1, kMaxEchoes));
  logs_[1].echoes.reserve(std::min(num_samples, kMaxEchoes));
}

void EchoLog::RecordSample(unsigned role_index, std::uint64_t sequence, std::int64_t sample_ns) noexcept {
  if (role_index >= departures_.size()) return;
  departures_[role_index][sequence % kWindow] = {core::MakeTraceId(role_index, sequence), sample_ns, {false, false}};
}

std::optional<std::int64_t> EchoLog::RecordWrite(const core::Header& header, std::int64_t write_ns) noexcept {
  RecordEcho(Chain::kThroughPhysics, header.through_physics, write_ns);
  return RecordEcho(Chain::kDirect, header.direct, write_ns);
}

std::optional<std::int64_t> EchoLog::RecordEcho(Chain chain, const core::Trace& trace, std::int64_t write_ns) noexcept {
  if (!trace.valid()) return std::nullopt;
  const std::uint64_t role = (trace.id >> 56) - 1;
  const std::uint64_t sequence = trace.id & 0x00ff'ffff'ffff'ffffULL;
  if (role >= departures_.size()) {
    ++num_unknown_;
    return std::nullopt;
  }
  Departure& departure = departures_[role][sequence % kWindow];
  if (departure.id != trace.id) {
    ++num_unknown_;
    return std::nullopt;
  }
  bool& has_returned = departure.has_returned[Index(chain)];
  if (has_returned) return std::nullopt;
  has_returned = true;
  Log& log = logs_[Index(chain)];
  const std::int64_t echo_ns = write_ns - departure.sample_ns;
  log.sum_ns += static_cast<double>(echo_ns);
  if (log.latencies_ns.size() < log.latencies_ns.capacity()) {
    log.latencies_ns.push_back(echo_ns);
  } else {
    ++num_not_kept_;
  }
  if (log.count++ % log.stride == 0 && log.echoes.size() < log.echoes.capacity())
    log.echoes.push_back({trace, echo_ns});
  return echo_ns;
}

LatencySummary EchoLog::Summary(Chain chain) const {
  LatencySummary summary;
  std::vector<std::int64_t> sorted = logs_[Index(chain)].latencies_ns;
  summary.n = sorted.size();
  if (sorted.empty()) return summary;
  std::sort(sorted.begin(), sorted.end());
  double sum_ns = 0.0;
  for (const std::int64_t latency_ns : sorted) sum_ns += static_cast<double>(latency_ns);
  // Nearest-rank percentile: the smallest value that at least this fraction of the samples does not exceed.
  const auto percentile_ms = [&](double fraction) {
    const auto rank = static_cast<std::size_t>(std::ceil(fraction * static_cast<double>(sorted.size())));
    return static_cast<double>(sorted[std::max<std::size_t>(rank, 1) - 1]) * 1e-6;
  };
  summary.mean_ms = sum_ns / static_cast<double>(sorted.size()) * 1e-6;
  summary.p50_ms = percentile_ms(0.5);
  summary.p90_ms = percentile_ms(0.9);
  summary.p99_ms = percentile_ms(0.99);
  summary.p999_ms = percentile_ms(0.999);
  summary.max_ms = static_cast<double>(sorted.back()) * 1e-6;
  return summary;
}

}  // namespace device_bridge
