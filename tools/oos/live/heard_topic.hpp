#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "bus/node.hpp"
#include "bus/rt/latency_stats.hpp"

namespace oos {

// Statistics of one topic as an observer received it. A message split into several datagrams counts once.
class HeardTopic {
 public:
  // `keeps_delays`: delay() will be called.
  explicit HeardTopic(bool keeps_delays = true);
  // `offset_ns`: the writer's clock minus ours, within +- `bound_ns`; INT64_MAX: not known.
  void Add(const bus::Observation& observation, std::int64_t offset_ns, std::int64_t bound_ns);

  [[nodiscard]] bus::TopicClass topic_class() const { return topic_class_; }
  [[nodiscard]] std::uint64_t num_messages() const { return num_messages_; }
  [[nodiscard]] double rate_Hz() const;
  [[nodiscard]] double longest_gap_ms() const { return static_cast<double>(longest_gap_ns_) * 1e-6; }
  // Bytes on the wire, envelopes included.
  [[nodiscard]] std::uint64_t num_bytes() const { return num_bytes_; }
  [[nodiscard]] double mean_bytes() const;
  [[nodiscard]] std::uint64_t smallest_bytes() const { return smallest_bytes_; }
  [[nodiscard]] std::uint64_t largest_bytes() const { return largest_bytes_; }

  // Delay from publishing to reception here; only LATEST messages carry their publish time. Memory is fixed, so the
  // percentiles are up to 3.2 % too large (bus::LatencyStats). By another machine's clock a delay can be negative, by
  // less than the bound: it counts as zero in the percentiles.
  struct Delay {
    std::size_t num = 0;
    double smallest_ms = 0.0, median_ms = 0.0, p99_ms = 0.0, largest_ms = 0.0;
    double bound_ms = 0.0;  // the largest; 0: the same machine
  };
  [[nodiscard]] Delay delay() const;
  [[nodiscard]] std::uint64_t num_without_clock() const { return num_without_clock_; }

 private:
  void EndMessage();

  bus::TopicClass topic_class_ = bus::TopicClass::kLatest;
  std::uint64_t num_messages_ = 0, num_bytes_ = 0;
  std::uint64_t open_bytes_ = 0;  // of the message whose parts come in
  std::uint64_t smallest_bytes_ = 0, largest_bytes_ = 0;
  std::int64_t first_ns_ = 0, last_ns_ = 0, longest_gap_ns_ = 0;
  std::unique_ptr<bus::LatencyStats> delays_;  // null: not kept
  std::int64_t smallest_delay_ns_ = 0, largest_delay_ns_ = 0;
  std::int64_t bound_ns_ = 0;
  std::uint64_t num_without_clock_ = 0;
};

// The statistics of all topics; delays use the writers' clocks as the observer knows them.
class HeardTopics {
 public:
  explicit HeardTopics(bool keeps_delays) : keeps_delays_(keeps_delays) {}
  void Add(const bus::Observation& observation, const std::vector<bus::PeerStatus>& peers);
  [[nodiscard]] const std::map<std::string, HeardTopic>& all() const { return all_; }

 private:
  bool keeps_delays_;
  std::map<std::string, HeardTopic> all_;
};

}  // namespace oos
