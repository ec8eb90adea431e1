#include "bus/latest/latest_spans.hpp"

#include "bus/node_core.hpp"
#include "proto/bus.pb.h"

namespace bus::detail {
namespace {

constexpr std::size_t kSpansPerHeartbeat = 6;  // some 40 bytes each: a fifth of a heartbeat

}  // namespace

void AddLatestSpans(const NodeCore& core, std::size_t* next, oos::Heartbeat* heartbeat) {
  const std::size_t slots = core.senders.size() * kMaxSubscribers;
  std::size_t num_added = 0;
  for (std::size_t num_visited = 0; num_visited < slots && num_added < kSpansPerHeartbeat; ++num_visited) {
    const std::size_t place = (*next)++ % slots;
    const LatestSender& sender = *core.senders[place / kMaxSubscribers];
    const SpanAccount& account = sender.spans[place % kMaxSubscribers];
    const std::uint64_t instance = account.instance.load(std::memory_order_acquire);
    const std::uint64_t first = account.first.load(std::memory_order_acquire);
    const std::uint64_t last = account.last.load(std::memory_order_acquire);
    // A slot that changed hands meanwhile is reported the next time.
    if (instance == 0 || account.instance.load(std::memory_order_acquire) != instance) continue;
    oos::LatestSpan* span = heartbeat->add_latest_spans();
    span->set_topic(sender.envelope.topic);
    span->set_reader(instance);
    span->set_boot(sender.envelope.boot);
    span->set_first(first);
    span->set_last(last);
    ++num_added;
  }
}

void TakeLatestSpans(const oos::Heartbeat& heartbeat, NodeCore* core) {
  for (const oos::LatestSpan& span : heartbeat.latest_spans()) {
    if (span.reader() != core->instance) continue;
    for (const auto& receiver : core->receivers) {
      if (receiver->id == span.topic())
        receiver->TakeReport(span.boot(), span.first(), span.last(), heartbeat.instance());
    }
  }
}

}  // namespace bus::detail
