#include "tools/oos/live/heard_topic.hpp"

#include <algorithm>

namespace oos {

HeardTopic::HeardTopic(bool keeps_delays) : delays_(keeps_delays ? std::make_unique<bus::LatencyStats>() : nullptr) {}

void HeardTopic::Add(const bus::Observation& observation, std::int64_t offset_ns, std::int64_t bound_ns) {
  topic_class_ = observation.topic_class;
  num_bytes_ += observation.num_bytes;
  open_bytes_ += observation.num_bytes;
  const bool is_copy = observation.num_bytes == 0;  // its own datagram was lost
  if (observation.part + 1 == observation.num_parts && !is_copy) EndMessage();
  if (observation.part != 0) return;
  if (num_messages_ == 0) {
    first_ns_ = observation.received_ns;
  } else {
    longest_gap_ns_ = std::max(longest_gap_ns_, observation.received_ns - last_ns_);
  }
  last_ns_ = observation.received_ns;
  ++num_messages_;
  if (topic_class_ != bus::TopicClass::kLatest) return;
  if (bound_ns == INT64_MAX) {
    ++num_without_clock_;
    return;
  }
  if (delays_ == nullptr) return;
  const std::int64_t delay_ns = observation.received_ns - (observation.publish_ns - offset_ns);
  smallest_delay_ns_ = delays_->count() == 0 ? delay_ns : std::min(smallest_delay_ns_, delay_ns);
  largest_delay_ns_ = delays_->count() == 0 ? delay_ns : std::max(largest_delay_ns_, delay_ns);
  delays_->Add(delay_ns);
  bound_ns_ = std::max(bound_ns_, bound_ns);
}

void HeardTopic::EndMessage() {
  smallest_bytes_ = largest_bytes_ == 0 ? open_bytes_ : std::min(smallest_bytes_, open_bytes_);
  largest_bytes_ = std::max(largest_bytes_, open_bytes_);
  open_bytes_ = 0;
}

double HeardTopic::rate_Hz() const {
  const double span_s = static_cast<double>(last_ns_ - first_ns_) * 1e-9;
  return span_s > 0.0 ? static_cast<double>(num_messages_ - 1) / span_s : 0.0;
}

double HeardTopic::mean_bytes() const {
  return num_messages_ == 0 ? 0.0 : static_cast<double>(num_bytes_) / static_cast<double>(num_messages_);
}

HeardTopic::Delay HeardTopic::delay() const {
  Delay delay;
  if (delays_ == nullptr || delays_->count() == 0) return delay;
  delay.num = delays_->count();
  delay.smallest_ms = static_cast<double>(smallest_delay_ns_) * 1e-6;
  delay.median_ms = delays_->p50_ns() * 1e-6;
  delay.p99_ms = delays_->p99_ns() * 1e-6;
  delay.largest_ms = static_cast<double>(largest_delay_ns_) * 1e-6;
  delay.bound_ms = static_cast<double>(bound_ns_) * 1e-6;
  return delay;
}

void HeardTopics::Add(const bus::Observation& observation, const std::vector<bus::PeerStatus>& peers) {
  std::int64_t offset_ns = 0, bound_ns = INT64_MAX;
  for (const bus::PeerStatus& peer : peers) {
    if (peer.name != observation.writer) continue;
    offset_ns = peer.clock_offset_ns;
    bound_ns = peer.clock_bound_ns;
  }
  all_.try_emplace(observation.topic, keeps_delays_).first->second.Add(observation, offset_ns, bound_ns);
}

}  // namespace oos
