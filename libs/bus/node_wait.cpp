// Node::Wait: takes datagrams and values of STATE into their readers, on the step thread.

#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <vector>

#include "bus/node.hpp"
#include "bus/node_impl.hpp"
#include "core/clock.hpp"

namespace bus {

WaitResult Node::Wait(std::int64_t deadline_ns) {
  detail::NodeCore& core = impl_->core;
  core.wait_count.fetch_add(1, std::memory_order_relaxed);
  for (const auto& receiver : core.receivers) receiver->ClearFresh();
  for (const auto& receiver : core.state_receivers) receiver->ClearFresh();
  WaitResult result;
  for (;;) {
    result.datagrams = impl_->TakeDatagrams();
    if (result.datagrams > 0) break;
    const std::int64_t left = deadline_ns - core::MonotonicNow_ns();
    if (left <= 0) {
      result.is_timeout = true;
      break;
    }
    // Without a group its descriptor is -1, which poll leaves out.
    std::array<pollfd, 2> items = {pollfd{core.data_socket.fd(), POLLIN, 0}, pollfd{core.group_socket.fd(), POLLIN, 0}};
    const timespec timeout{static_cast<time_t>(left / core::kNanosecondsPerSecond),
                           static_cast<long>(left % core::kNanosecondsPerSecond)};
    if (ppoll(items.data(), items.size(), &timeout, nullptr) < 0) {  // a signal: the caller decides what it means
      result.datagrams = impl_->TakeDatagrams();
      break;
    }
    core.guard->TakeSenders();
    if (items[0].revents != 0) result.datagrams += impl_->TakeFirst(core.data_socket);
    if (items[1].revents != 0) result.datagrams += impl_->TakeFirst(core.group_socket);
    if (result.datagrams > 0) break;
  }
  impl_->TakeStates();
  return result;
}

// Takes the datagram that ended a sleep, and the other parts of its message. Usually nothing else has arrived, and
// recvmmsg would need a second pass in the kernel to find that out: it takes 1 us longer than recv. Further datagrams
// end the next Wait at once.
int Node::Impl::TakeFirst(const detail::UdpSocket& socket) {
  const ssize_t size = recv(socket.fd(), buffers[0].data(), buffers[0].size(), MSG_DONTWAIT);
  if (size < 0) return 0;
  envelope.num_parts = 1;
  TakeDatagram({buffers[0].data(), static_cast<std::size_t>(size)}, core::MonotonicNow_ns(),
               &socket == &core.group_socket);
  return envelope.num_parts == 1 ? 1 : 1 + TakeDatagrams(socket);
}

int Node::Impl::TakeDatagrams() {
  core.guard->TakeSenders();
  const int total = TakeDatagrams(core.data_socket);
  return core.group_socket.fd() < 0 ? total : total + TakeDatagrams(core.group_socket);
}

int Node::Impl::TakeDatagrams(const detail::UdpSocket& socket) {
  int total = 0;
  for (;;) {
    const int count = recvmmsg(socket.fd(), headers.data(), kBatch, MSG_DONTWAIT, nullptr);
    if (count <= 0) return total;
    const std::int64_t now = core::MonotonicNow_ns();
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      TakeDatagram({buffers[i].data(), headers[i].msg_len}, now, &socket == &core.group_socket);
    }
    total += count;
    if (static_cast<std::size_t>(count) < kBatch || total >= 64 * static_cast<int>(kBatch)) return total;
  }
}

void Node::Impl::TakeDatagram(std::span<std::uint8_t> bytes, std::int64_t now_ns, bool is_of_group) {
  if (is_of_group && detail::IsFromNode(core.identity.node, bytes)) return;  // its own comes back
  std::span<const std::uint8_t> payload;
  detail::Refusal refusal = core.guard->OpenData(bytes, &envelope, &payload);
  if (refusal == detail::Refusal::kNone && envelope.topic_class != TopicClass::kLatest) {
    refusal = detail::Refusal::kUnknownTopic;
  }
  if (refusal == detail::Refusal::kNone) {
    detail::LatestReceiver* receiver = FindReceiver(envelope.topic);
    const bool is_observing = !core.observed_patterns.empty();
    if (is_observing) Observe(payload, bytes.size(), now_ns);
    if (receiver != nullptr) {
      refusal = receiver->Take(envelope, payload, now_ns);
    } else if (!is_observing && !is_of_group) {  // a group receives topics that any of its members reads
      refusal = detail::Refusal::kUnknownTopic;
    }
  }
  if (refusal != detail::Refusal::kNone) core.guard->refusals.Add(refusal);
}

void Node::Impl::Observe(std::span<const std::uint8_t> payload, std::size_t num_bytes, std::int64_t now_ns) {
  const std::lock_guard lock(core.mutex);
  const auto known = core.known_topics.find(envelope.topic);
  if (known == core.known_topics.end() || !core.IsObserved(known->second.name)) return;
  ObservedLife& life = observed[envelope.topic];
  const auto add = [&](const core::Header& header, std::size_t bytes, std::span<const std::uint8_t> message) {
    core.AddObservation({known->second.name, TopicClass::kLatest, known->second.type, known->second.writer,
                         header.sequence, header.publish_ns, now_ns, bytes, envelope.part, envelope.num_parts,
                         std::string(message.begin(), message.end())});
  };
  const bool is_new = IsNewToObserver(&life);
  std::vector<detail::EarlierSample> missing;  // newest first; observed in order
  std::span<const std::uint8_t> blocks{payload.data() + payload.size(), envelope.history_bytes};
  detail::EarlierSample sample;
  while (envelope.boot == life.boot && detail::NextEarlierSample(envelope.header.sequence, &blocks, &sample)) {
    if (!life.tracker.IsMissing(sample.header.sequence)) continue;
    life.tracker.Restore(sample.header.sequence);
    missing.push_back(sample);
  }
  for (auto it = missing.rbegin(); it != missing.rend(); ++it) add(it->header, 0, it->payload);
  if (is_new) add(envelope.header, num_bytes, payload);
}

// Whether the datagram's message has not been observed already, as a copy in a later datagram. One that is older than
// the window is skipped; it counts as lost for a reader, too.
bool Node::Impl::IsNewToObserver(ObservedLife* life) const {
  if (envelope.boot < life->boot) return true;  // of an earlier life: always shown
  if (envelope.boot > life->boot) *life = {envelope.boot, {}};
  const bool is_first = envelope.header.sequence > life->tracker.newest();
  if (envelope.num_parts > 1) {  // its parts arrive one by one, never as copies
    if (is_first) life->tracker.Take(envelope.header.sequence);
    return true;
  }
  const detail::SequenceTracker::Verdict verdict = life->tracker.Take(envelope.header.sequence);
  return verdict == detail::SequenceTracker::Verdict::kNew || verdict == detail::SequenceTracker::Verdict::kLate;
}

void Node::Impl::TakeStates() {
  while (const detail::StateItem* item = core.states_in.Front()) {
    if (!core.state_receivers[item->slot]->Take(*item)) core.refused.fetch_add(1, std::memory_order_relaxed);
    core.tap.TookState(*item);
    core.states_in.EndPop();
  }
}

}  // namespace bus
