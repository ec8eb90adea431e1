#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace bus {

namespace detail {
struct LatestSender;
struct LatestAccess;
}  // namespace detail

// Writing end of a LATEST topic; M is core::DeviceState, DeviceCommand, HapticProxy, ContactSet, PhysicsState,
// Reaction or SheetState. A handle: copy it freely, one thread at a time may use it.
template <class M>
class LatestWriter {
 public:
  LatestWriter() = default;

  // Sets header.sequence and header.publish_ns and sends to every subscriber. No lock, no allocation once warm; a full
  // socket buffer counts as a drop. Returns the number of datagrams handed to the socket.
  int Send(M& message) noexcept;
  [[nodiscard]] bool has_subscribers() const noexcept;  // nothing is encoded or sent without one

 private:
  friend class Node;
  detail::LatestSender* sender_ = nullptr;
};

// Reading end: the newest message by (boot id of the writer, sequence). Older arrivals are counted, not shown.
//
// Age of the value when it is read: with one message per period T, a hop of at most h and the last k messages lost,
// age by publish time <= (k + 1) T + h.
template <class M>
class LatestReader {
 public:
  [[nodiscard]] const M& value() const { return value_; }  // header.sequence 0: nothing has arrived yet
  [[nodiscard]] bool has_value() const { return value_.header.sequence != 0; }
  [[nodiscard]] bool is_fresh() const { return is_fresh_; }                // the last Wait() brought it
  [[nodiscard]] std::int64_t received_ns() const { return received_ns_; }  // CLOCK_MONOTONIC of this host
  // Time since it arrived here [ns]; INT64_MAX: no value.
  [[nodiscard]] std::int64_t age_ns(std::int64_t now_ns) const {
    return has_value() ? now_ns - received_ns_ : std::numeric_limits<std::int64_t>::max();
  }
  // Time since it was published [ns]; INT64_MAX: no value. `clock_offset_ns` is this host's clock minus the writer's (0
  // on one machine); the age is as uncertain as the offset.
  [[nodiscard]] std::int64_t publish_age_ns(std::int64_t now_ns, std::int64_t clock_offset_ns = 0) const {
    return has_value() ? now_ns - (value_.header.publish_ns + clock_offset_ns)
                       : std::numeric_limits<std::int64_t>::max();
  }
  // Older than the topic table allows: a stale value must not be acted on.
  [[nodiscard]] bool is_stale(std::int64_t now_ns) const { return max_age_ns_ > 0 && age_ns(now_ns) > max_age_ns_; }
  [[nodiscard]] std::uint32_t restarts() const { return restarts_; }  // of the writer, seen by this reader

  // For readers that need every sample (derivatives, recordings): keeps the newest `num_samples` by sequence. It also
  // makes the writer repeat the one or two previous samples in each datagram that has room for them, so that up to two
  // consecutive losses leave no gap. Before Node::Start(); allocates.
  void KeepHistory(std::size_t num_samples) { history_.resize(num_samples); }
  [[nodiscard]] bool keeps_history() const { return !history_.empty(); }
  // Null: lost, no longer kept, or from before the writer's start.
  [[nodiscard]] const M* Sample(std::uint64_t sequence) const {
    if (history_.empty() || sequence == 0) return nullptr;
    const M& sample = history_[sequence % history_.size()];
    return sample.header.sequence == sequence ? &sample : nullptr;
  }

 private:
  friend class Node;
  friend struct detail::LatestAccess;
  M value_{};
  M staging_{};             // a message of several datagrams until it is complete
  std::vector<M> history_;  // by sequence modulo its size
  std::int64_t received_ns_ = 0;
  std::int64_t max_age_ns_ = 0;
  std::uint32_t restarts_ = 0;
  bool is_fresh_ = false;
};

}  // namespace bus
