#include "bus/latest/latest_io.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "bus/wire/schema.hpp"
#include "core/clock.hpp"

namespace bus {
namespace detail {
namespace {

std::span<const std::uint8_t> InMemory(const Envelope& envelope) {
  return {reinterpret_cast<const std::uint8_t*>(&envelope), sizeof envelope};
}

}  // namespace

// --- Sending

bool IsFromNode(std::uint32_t node, std::span<const std::uint8_t> datagram) noexcept {
  constexpr std::size_t kNodePlace = 24;  // bus/wire/envelope.hpp
  std::uint32_t written = 0;
  if (datagram.size() < kNodePlace + sizeof written) return false;
  std::memcpy(&written, datagram.data() + kNodePlace, sizeof written);
  return written == node;
}

LatestSender::LatestSender(std::string topic_name, MessageType message_type)
    : topic(std::move(topic_name)), type(message_type) {
  envelope.topic_class = TopicClass::kLatest;
  envelope.topic = TopicId(topic);
  envelope.schema_digest = SchemaOf(type).digest;
}

void LatestSender::SetReaders(const Subscribers& readers) {
  const auto reads = [&readers](std::uint64_t instance) {
    return std::any_of(readers.begin(), readers.end(),
                       [instance](const Subscriber& reader) { return reader.instance == instance; });
  };
  Subscribers& list = subscribers.BeginWrite();
  list = readers;
  for (Subscriber& reader : list) {
    auto slot = std::find(slots.begin(), slots.end(), reader.instance);
    // A reader that returns finds its account again, unless others needed the slot.
    if (slot == slots.end()) slot = std::find(slots.begin(), slots.end(), std::uint64_t{0});
    if (slot == slots.end()) slot = std::find_if_not(slots.begin(), slots.end(), reads);
    *slot = reader.instance;
    reader.slot = static_cast<std::size_t>(slot - slots.begin());
  }
  subscribers.EndWrite();
}

void LatestSender::CountFor(const Subscriber& reader) noexcept {
  SpanAccount& span = spans[reader.slot];
  if (span.instance.load(std::memory_order_relaxed) != reader.instance) {
    span.instance.store(0, std::memory_order_release);
    span.first.store(sequence, std::memory_order_release);
    span.last.store(sequence, std::memory_order_release);
    span.instance.store(reader.instance, std::memory_order_release);
  }
  span.last.store(sequence, std::memory_order_release);
}

std::uint64_t LatestSender::SendToAll(const Subscribers& readers, std::span<const std::uint8_t> datagram,
                                      int* datagrams) noexcept {
  const std::uint64_t all = (std::uint64_t{1} << readers.size()) - 1;
  if (datagram.empty()) return all;
  if (detour != nullptr) {
    if (!readers.empty() && !PutOnDetour(readers, datagram)) return all;
    *datagrams += static_cast<int>(readers.size());
    return 0;
  }
  // One datagram for all members of the group.
  const bool has_group = std::any_of(readers.begin(), readers.end(), [](const Subscriber& r) { return r.is_in_group; });
  const bool is_grouped = has_group && socket->Send(group, datagram.data(), datagram.size());
  *datagrams += is_grouped ? 1 : 0;
  std::uint64_t missed = 0;
  for (std::size_t i = 0; i < readers.size(); ++i) {
    const bool is_sent =
        readers[i].is_in_group ? is_grouped : socket->Send(readers[i].address, datagram.data(), datagram.size());
    *datagrams += is_sent && !readers[i].is_in_group ? 1 : 0;
    missed |= is_sent ? 0 : std::uint64_t{1} << i;
  }
  return missed;
}

bool LatestSender::PutOnDetour(const Subscribers& readers, std::span<const std::uint8_t> datagram) noexcept {
  DetouredDatagram* slot = detour->BeginPush();
  if (slot == nullptr) return false;
  std::copy(datagram.begin(), datagram.end(), slot->bytes.begin());
  slot->size = datagram.size();
  slot->readers.clear();
  for (const Subscriber& reader : readers) slot->readers.push_back(reader.instance);
  detour->EndPush();
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = write(wake_fd, &one, sizeof(one));
  return true;
}

template <class M>
std::size_t TypedSender<M>::WriteDatagram(const M& message, std::uint8_t* bytes) noexcept {
  const bool is_sealed = guard->is_sealed();
  const std::size_t head = EnvelopeBytes(message.header);
  const std::size_t budget = kMaxDatagramBytes - head - (is_sealed ? kSealBytes : 0);
  const std::size_t payload = codec_.Encode(message, envelope.part, budget, bytes + head, budget);
  envelope.history_bytes = 0;
  if (tap != nullptr) {
    const std::int64_t now_ns = message.header.publish_ns;
    tap->Put(tap_slot, sequence, now_ns, now_ns, InMemory(envelope),
             {bytes + head, payload == kDoesNotFit ? 0 : payload});
  }
  const Subscribers& readers = subscribers.value();
  if (payload == kDoesNotFit || readers.empty()) return 0;
  const auto wants_history = [](const Subscriber& reader) { return reader.wants_history; };
  if (envelope.num_parts == 1 && std::any_of(readers.begin(), readers.end(), wants_history)) {
    envelope.history_bytes =
        static_cast<std::uint16_t>(earlier.Write(sequence, bytes + head + payload, budget - payload));
    earlier.Keep(message.header, {bytes + head, payload});
  }
  return is_sealed ? guard->SealData(bytes, WriteEnvelopeToSeal(envelope, payload, bytes))
                   : WriteEnvelope(envelope, payload, bytes);
}

template <class M>
int TypedSender<M>::Send(M* message) noexcept {
  subscribers.Update();
  message->header.sequence = ++sequence;
  message->header.publish_ns = core::MonotonicNow_ns();
  const Subscribers& readers = subscribers.value();
  if (readers.empty() && tap == nullptr) return 0;

  envelope.header = message->header;
  const std::size_t budget = kMaxDatagramBytes - EnvelopeBytes(message->header) - (guard->is_sealed() ? kSealBytes : 0);
  const int parts = codec_.NumParts(*message, budget);
  envelope.num_parts = static_cast<std::uint8_t>(parts);
  std::array<std::uint8_t, kMaxDatagramBytes> bytes;
  std::uint64_t missed = 0;  // bit per reader for which the socket refused a part
  int datagrams = 0;
  for (int part = 0; part < parts; ++part) {
    envelope.part = static_cast<std::uint8_t>(part);
    const std::size_t size = WriteDatagram(*message, bytes.data());
    missed |= SendToAll(readers, {bytes.data(), size}, &datagrams);
  }
  for (const Subscriber& reader : readers) CountFor(reader);
  const auto num_missed = static_cast<std::uint64_t>(std::popcount(missed));
  sent.fetch_add(readers.size() - num_missed, std::memory_order_relaxed);
  if (num_missed != 0) dropped.fetch_add(num_missed, std::memory_order_relaxed);
  return datagrams;
}

// --- Receiving

// Converts the stamps to this machine's clock; removes them when the writer's clock is not known.
void ToOwnClock(std::int64_t offset_ns, core::Header* header) noexcept {
  if (offset_ns == kUnknownClock) {
    header->publish_ns = 0;
    header->direct = {};
    header->through_physics = {};
    return;
  }
  header->publish_ns -= offset_ns;
  header->direct.origin_ns -= offset_ns;
  header->through_physics.origin_ns -= offset_ns;
}

LatestReceiver::LatestReceiver(std::string topic_name, MessageType message_type)
    : topic(std::move(topic_name)), type(message_type), id(TopicId(topic)), digest(SchemaOf(type).digest) {}

void LatestReceiver::Publish() noexcept {
  const std::uint64_t span = tracker.newest() == 0 ? 0 : tracker.newest() - tracker.first() + 1;
  const Tally present{span,           tracker.received(),  tracker.restored(),
                      tracker.lost(), tracker.reordered(), tracker.repeated()};
  seen_.Write({boot, tracker.first(), tracker.newest(), present, past_});
}

namespace {

// How many of first .. last lie outside of the range that the tracker accounts for.
std::uint64_t Unseen(std::uint64_t first, std::uint64_t last, std::uint64_t seen_first, std::uint64_t seen_newest) {
  if (first == 0 || last < first) return 0;
  if (seen_newest == 0) return last - first + 1;
  return (first < seen_first ? std::min(seen_first, last + 1) - first : 0) +
         (last > seen_newest ? last - std::max(seen_newest, first - 1) : 0);
}

}  // namespace

// Closes the accounts of the earlier lives: the one that was read, and one of which nothing arrived.
void LatestReceiver::Restart(std::uint64_t new_boot) noexcept {
  std::uint64_t unseen = 0;
  for (const WriterReport& report : reported_) {
    const std::uint64_t reported_boot = report.boot.load(std::memory_order_acquire);
    if (reported_boot == 0 || reported_boot < boot || reported_boot >= new_boot) continue;
    unseen += Unseen(report.first.load(std::memory_order_relaxed), report.last.load(std::memory_order_relaxed),
                     tracker.first(), reported_boot == boot ? tracker.newest() : 0);
  }
  past_.meant += unseen + (tracker.newest() == 0 ? 0 : tracker.newest() - tracker.first() + 1);
  past_.received += tracker.received();
  past_.restored += tracker.restored();
  past_.lost += unseen + tracker.lost();
  past_.reordered += tracker.reordered();
  past_.repeated += tracker.repeated();
  tracker.Restart();
  boot = new_boot;
  Publish();
}

void LatestReceiver::TakeReport(std::uint64_t writer_boot, std::uint64_t first, std::uint64_t last,
                                std::uint64_t instance) noexcept {
  WriterReport& older =
      reported_[reported_[0].boot.load(std::memory_order_relaxed) <= reported_[1].boot.load(std::memory_order_relaxed)
                    ? 0
                    : 1];
  WriterReport& newer = &older == reported_.data() ? reported_[1] : reported_[0];
  const std::uint64_t newest_boot = newer.boot.load(std::memory_order_relaxed);
  if (writer_boot < newest_boot) return;  // overtaken on the way
  if (writer_boot > newest_boot) {        // the earlier life reports no more
    Settle();
    older.boot.store(0, std::memory_order_release);
    older.first.store(first, std::memory_order_relaxed);
    older.last.store(last, std::memory_order_relaxed);
    older.settled.store(0, std::memory_order_relaxed);
    older.instance.store(instance, std::memory_order_relaxed);
    older.boot.store(writer_boot, std::memory_order_release);
    return;
  }
  const std::uint64_t reported_last = newer.last.load(std::memory_order_relaxed);
  if (last < reported_last) return;  // overtaken on the way
  newer.settled.store(reported_last, std::memory_order_relaxed);
  newer.first.store(first, std::memory_order_relaxed);
  newer.last.store(last, std::memory_order_relaxed);
}

void LatestReceiver::Settle() noexcept {
  for (WriterReport& report : reported_)
    report.settled.store(report.last.load(std::memory_order_relaxed), std::memory_order_relaxed);
}

std::uint64_t LatestReceiver::UnseenOfOpenLives(const Seen& seen,
                                                std::atomic<std::uint64_t> WriterReport::*last) const noexcept {
  std::uint64_t unseen = 0;
  for (const WriterReport& report : reported_) {
    const std::uint64_t reported_boot = report.boot.load(std::memory_order_acquire);
    if (reported_boot == 0 || reported_boot < seen.boot) continue;
    unseen += Unseen(report.first.load(std::memory_order_relaxed), (report.*last).load(std::memory_order_relaxed),
                     seen.first, reported_boot == seen.boot ? seen.newest : 0);
  }
  return unseen;
}

LatestCounts LatestReceiver::Counts() const noexcept {
  const Seen seen = seen_.Read();
  LatestCounts counts;
  counts.meant = seen.past.meant + seen.present.meant + UnseenOfOpenLives(seen, &WriterReport::last);
  counts.received = seen.past.received + seen.present.received;
  counts.restored = seen.past.restored + seen.present.restored;
  counts.dropped = seen.past.lost + seen.present.lost + UnseenOfOpenLives(seen, &WriterReport::settled);
  counts.reordered = seen.past.reordered + seen.present.reordered;
  counts.repeated = seen.past.repeated + seen.present.repeated;
  return counts;
}

LatestLife LatestReceiver::Life() const noexcept {
  const Seen seen = seen_.Read();
  const WriterReport& report =
      reported_[reported_[0].boot.load(std::memory_order_acquire) > reported_[1].boot.load(std::memory_order_acquire)
                    ? 0
                    : 1];
  LatestLife life;
  life.boot = report.boot.load(std::memory_order_acquire);
  if (life.boot == 0) return life;
  life.instance = report.instance.load(std::memory_order_relaxed);
  life.first = report.first.load(std::memory_order_relaxed);
  life.last = report.last.load(std::memory_order_relaxed);
  const bool is_seen = seen.boot == life.boot && seen.newest != 0;
  const std::uint64_t newest = is_seen ? seen.newest : 0;
  const std::uint64_t settled = Unseen(life.first, report.settled.load(std::memory_order_relaxed), seen.first, newest);
  if (is_seen) {
    life.received = seen.present.received;
    life.restored = seen.present.restored;
    life.lost = seen.present.lost;
    if (seen.first < life.first) life.early = std::min(life.first, seen.newest + 1) - seen.first;
  }
  life.lost += settled;
  const std::uint64_t unseen = Unseen(life.first, life.last, seen.first, newest);
  life.on_the_way = unseen - std::min(unseen, settled);
  return life;
}

template <class M>
TypedReceiver<M>::TypedReceiver(const std::string& topic_name, std::int64_t max_age_ns)
    : LatestReceiver(topic_name, kMessageTypeOf<M>) {
  LatestAccess::SetMaxAge(&reader, max_age_ns);
}

template <class M>
Refusal TypedReceiver<M>::Take(const Envelope& envelope, std::span<const std::uint8_t> payload,
                               std::int64_t now_ns) noexcept {
  if (envelope.schema_digest != digest && envelope.schema_digest != other_digest.load(std::memory_order_relaxed)) {
    return Refusal::kBadSchema;
  }
  const std::uint64_t sequence = envelope.header.sequence;
  if (sequence == 0 || envelope.num_parts > 64) return Refusal::kBadSchema;
  if (envelope.boot < boot) {  // from before the writer's restart
    CountStraggler();
    Publish();
    return Refusal::kNone;
  }
  Refusal refusal = Refusal::kNone;
  if (envelope.boot > boot || sequence > tracker.newest()) {
    refusal = TakeNewer(envelope, payload, now_ns);
  } else {
    TakeOlder(envelope, payload);
  }
  if (refusal == Refusal::kNone && envelope.history_bytes != 0) {
    TakeEarlier(sequence, {payload.data() + payload.size(), envelope.history_bytes});
  }
  Publish();
  return refusal;
}

template <class M>
Refusal TypedReceiver<M>::TakeNewer(const Envelope& envelope, std::span<const std::uint8_t> payload,
                                    std::int64_t now_ns) noexcept {
  const std::uint64_t sequence = envelope.header.sequence;
  const bool is_restart = envelope.boot > boot;
  const bool is_first = is_restart || sequence != staging_sequence_;
  // Older than a message that is being assembled; lost once that one is complete.
  if (!is_restart && sequence < staging_sequence_) return Refusal::kNone;
  M& staging = LatestAccess::Staging(&reader);
  if (!codec_.Decode(payload, is_first, &staging)) return Refusal::kBadSchema;
  if (tap != nullptr) tap->Put(tap_slot, sequence, now_ns, envelope.header.publish_ns, InMemory(envelope), {});
  if (is_restart) {
    if (boot != 0) LatestAccess::Restart(&reader);
    Restart(envelope.boot);
  }
  if (is_first) {
    staging_sequence_ = sequence;
    staging_parts_ = 0;
  }
  staging_parts_ |= std::uint64_t{1} << envelope.part;
  if (std::popcount(staging_parts_) != envelope.num_parts) return Refusal::kNone;

  tracker.Take(sequence);
  staging.header = envelope.header;
  ToOwnClock(clock_offset_ns.load(std::memory_order_relaxed), &staging.header);
  LatestAccess::Accept(&reader, now_ns);
  if (M* place = LatestAccess::Place(&reader, sequence, sequence)) *place = staging;
  return Refusal::kNone;
}

template <class M>
void TypedReceiver<M>::TakeOlder(const Envelope& envelope, std::span<const std::uint8_t> payload) noexcept {
  // Only a message in one part is counted as late or repeated; the parts of an older split message are ignored.
  if (envelope.num_parts != 1) return;
  if (tracker.Take(envelope.header.sequence) == SequenceTracker::Verdict::kLate) Keep(envelope.header, payload);
}

template <class M>
void TypedReceiver<M>::TakeEarlier(std::uint64_t sequence, std::span<const std::uint8_t> blocks) noexcept {
  if (!reader.keeps_history()) return;  // requested by another reader
  EarlierSample sample;
  while (NextEarlierSample(sequence, &blocks, &sample)) {
    if (tracker.IsMissing(sample.header.sequence) && Keep(sample.header, sample.payload)) {
      tracker.Restore(sample.header.sequence);
    }
  }
}

template <class M>
bool TypedReceiver<M>::Keep(const core::Header& header, std::span<const std::uint8_t> payload) noexcept {
  M* place = LatestAccess::Place(&reader, header.sequence, tracker.newest());
  if (place == nullptr || !codec_.Decode(payload, true, place)) return false;
  place->header = header;
  ToOwnClock(clock_offset_ns.load(std::memory_order_relaxed), &place->header);
  return true;
}

#define LATEST_ENDS(Message)                  \
  template struct TypedSender<core::Message>; \
  template struct TypedReceiver<core::Message>;
BUS_LATEST_MESSAGES(LATEST_ENDS)

}  // namespace detail

template <class M>
int LatestWriter<M>::Send(M& message) noexcept {
  return sender_ == nullptr ? 0 : static_cast<detail::TypedSender<M>*>(sender_)->Send(&message);
}

template <class M>
bool LatestWriter<M>::has_subscribers() const noexcept {
  if (sender_ == nullptr) return false;
  sender_->subscribers.Update();
  return !sender_->subscribers.value().empty();
}

#define LATEST_WRITER(Message) template class LatestWriter<core::Message>;
BUS_LATEST_MESSAGES(LATEST_WRITER)

}  // namespace bus
