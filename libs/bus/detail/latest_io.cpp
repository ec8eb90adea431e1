#include "bus/detail/latest_io.hpp"

#include <array>
#include <bit>

#include "bus/schema.hpp"
#include "core/clock.hpp"

namespace bus {
namespace detail {

namespace {

std::span<const std::uint8_t> InMemory(const Envelope& envelope) {
  return {reinterpret_cast<const std::uint8_t*>(&envelope), sizeof envelope};
}

}  // namespace

LatestSender::LatestSender(std::string topic_name, MessageType message_type)
    : topic(std::move(topic_name)), type(message_type) {
  envelope.topic_class = TopicClass::kLatest;
  envelope.topic = TopicId(topic);
  envelope.schema_digest = SchemaOf(type).digest;
}

template <class M>
int TypedSender<M>::Send(M* message) noexcept {
  subscribers.Update();
  message->header.sequence = ++sequence;
  message->header.publish_ns = core::MonotonicNow_ns();
  const Subscribers& readers = subscribers.value();
  if (readers.empty() && tap == nullptr) return 0;

  envelope.header = message->header;
  const std::size_t head = EnvelopeBytes(message->header);
  const std::size_t budget = kMaxDatagramBytes - head;
  const int parts = codec.NumParts(*message, budget);
  envelope.num_parts = static_cast<std::uint8_t>(parts);
  std::array<std::uint8_t, kMaxDatagramBytes> bytes;
  std::uint64_t missed = 0;  // bit per reader that did not get every part
  int datagrams = 0;
  for (int part = 0; part < parts; ++part) {
    envelope.part = static_cast<std::uint8_t>(part);
    const std::size_t payload = codec.Encode(*message, part, budget, bytes.data() + head, bytes.size() - head);
    if (tap != nullptr) {
      const std::int64_t now_ns = message->header.publish_ns;
      tap->Put(tap_slot, sequence, now_ns, now_ns, InMemory(envelope), std::span(bytes).subspan(head, payload));
    }
    if (readers.empty()) continue;
    const std::size_t size = payload == 0 ? 0 : WriteEnvelope(envelope, payload, bytes.data());
    for (std::size_t i = 0; i < readers.size(); ++i) {
      if (size != 0 && socket->Send(readers[i], bytes.data(), size)) {
        ++datagrams;
      } else {
        missed |= std::uint64_t{1} << i;
      }
    }
  }
  const auto num_missed = static_cast<std::uint64_t>(std::popcount(missed));
  sent.fetch_add(readers.size() - num_missed, std::memory_order_relaxed);
  dropped.fetch_add(num_missed, std::memory_order_relaxed);
  return datagrams;
}

SequenceTracker::Verdict SequenceTracker::Take(std::uint64_t sequence) {
  lost_by_last_ = 0;
  if (sequence > newest_) {
    const std::uint64_t step = sequence - newest_;
    // What was sent before the first arrival is not lost: nobody was listening.
    if (newest_ != 0) lost_by_last_ = static_cast<std::int64_t>(step - 1);
    seen_ = newest_ == 0 ? ~std::uint64_t{0} : step < 64 ? seen_ << step : 0;
    seen_ |= 1;
    newest_ = sequence;
    return Verdict::kNew;
  }
  const std::uint64_t behind = newest_ - sequence;
  if (behind >= 64) return Verdict::kLate;  // too old to know: stays counted as lost
  const std::uint64_t bit = std::uint64_t{1} << behind;
  if ((seen_ & bit) != 0) return Verdict::kRepeated;
  seen_ |= bit;
  lost_by_last_ = -1;
  return Verdict::kLate;
}

LatestReceiver::LatestReceiver(std::string topic_name, MessageType message_type)
    : topic(std::move(topic_name)), type(message_type), id(TopicId(topic)), digest(SchemaOf(type).digest) {}

template <class M>
TypedReceiver<M>::TypedReceiver(const std::string& topic_name, std::int64_t max_age_ns)
    : LatestReceiver(topic_name, kMessageTypeOf<M>) {
  LatestAccess::SetMaxAge(&reader, max_age_ns);
}

template <class M>
void TypedReceiver<M>::ClearFresh() noexcept {
  LatestAccess::ClearFresh(&reader);
}

template <class M>
bool TypedReceiver<M>::Take(const Envelope& envelope, std::span<const std::uint8_t> payload,
                            std::int64_t now_ns) noexcept {
  if (envelope.schema_digest != digest && envelope.schema_digest != other_digest.load(std::memory_order_relaxed)) {
    return false;
  }
  const std::uint64_t sequence = envelope.header.sequence;
  if (sequence == 0 || envelope.num_parts > 64) return false;
  if (envelope.boot < boot) {  // from before the writer's restart
    reordered.fetch_add(1, std::memory_order_relaxed);
    return true;
  }
  const bool is_restart = envelope.boot > boot;
  const bool is_newer = is_restart || sequence > tracker.newest();

  M& staging = LatestAccess::Staging(&reader);
  if (!is_newer) {
    // Only a whole message can be told late or repeated from its sequence alone; parts of one that was overtaken count
    // once.
    if (envelope.part == 0) {
      if (tracker.Take(sequence) == SequenceTracker::Verdict::kLate) {
        reordered.fetch_add(1, std::memory_order_relaxed);
        if (envelope.num_parts == 1 && tracker.lost_by_last() < 0) dropped.fetch_sub(1, std::memory_order_relaxed);
      }
    }
    return true;
  }
  const bool is_first = is_restart || sequence != staging_sequence;
  if (!is_restart && sequence < staging_sequence) return true;  // overtaken; counted when the newer one is complete
  if (!codec.Decode(payload, is_first, &staging)) return false;
  if (tap != nullptr) tap->Put(tap_slot, sequence, now_ns, envelope.header.publish_ns, InMemory(envelope), {});
  if (is_restart) {
    if (boot != 0) LatestAccess::CountRestart(&reader);
    boot = envelope.boot;
    tracker.Restart();
  }
  if (is_first) {
    staging_sequence = sequence;
    staging_parts = 0;
  }
  staging_parts |= std::uint64_t{1} << envelope.part;
  if (std::popcount(staging_parts) != envelope.num_parts) return true;

  tracker.Take(sequence);
  dropped.fetch_add(static_cast<std::uint64_t>(tracker.lost_by_last()), std::memory_order_relaxed);
  received.fetch_add(1, std::memory_order_relaxed);
  staging.header = envelope.header;
  LatestAccess::Accept(&reader, now_ns);
  return true;
}

template struct TypedSender<core::DeviceState>;
template struct TypedSender<core::DeviceCommand>;
template struct TypedSender<core::HapticProxy>;
template struct TypedSender<core::ContactSet>;
template struct TypedSender<core::PhysicsState>;
template struct TypedSender<core::Reaction>;
template struct TypedSender<core::SheetState>;
template struct TypedReceiver<core::DeviceState>;
template struct TypedReceiver<core::DeviceCommand>;
template struct TypedReceiver<core::HapticProxy>;
template struct TypedReceiver<core::ContactSet>;
template struct TypedReceiver<core::PhysicsState>;
template struct TypedReceiver<core::Reaction>;
template struct TypedReceiver<core::SheetState>;

}  // namespace detail

template <class M>
int LatestWriter<M>::Send(M& message) noexcept {
  return sender_ == nullptr ? 0 : static_cast<detail::TypedSender<M>*>(sender_)->Send(&message);
}

template <class M>
bool LatestWriter<M>::has_subscribers() const noexcept {
  if (sender_ == nullptr) return false;
  sender_->subscribers.Update();
  return !sender_->subscribers.value().empty() || sender_->tap != nullptr;
}

template class LatestWriter<core::DeviceState>;
template class LatestWriter<core::DeviceCommand>;
template class LatestWriter<core::HapticProxy>;
template class LatestWriter<core::ContactSet>;
template class LatestWriter<core::PhysicsState>;
template class LatestWriter<core::Reaction>;
template class LatestWriter<core::SheetState>;

}  // namespace bus
