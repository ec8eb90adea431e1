#pragma once

#include <netinet/in.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "bus/accounts/ledger.hpp"
#include "bus/latest/history.hpp"
#include "bus/latest/latest.hpp"
#include "bus/latest/sequence_tracker.hpp"
#include "bus/latest/udp_socket.hpp"
#include "bus/log/tap.hpp"
#include "bus/rt/latest_value.hpp"
#include "bus/rt/published.hpp"
#include "bus/rt/spsc_ring.hpp"
#include "bus/security/datagram_guard.hpp"
#include "bus/wire/codec.hpp"
#include "bus/wire/envelope.hpp"
#include "core/fixed_vector.hpp"

namespace bus::detail {

// Who this node is, in every envelope that it sends.
struct Identity {
  std::uint64_t session = 0;
  std::uint32_t node = 0;
  std::uint64_t boot = 0;
};

// Readers of one LATEST topic: five nodes and some observers; fixed, so that sending never allocates.
constexpr std::size_t kMaxSubscribers = 16;

struct Subscriber {
  sockaddr_in address{};
  std::uint64_t instance = 0;
  std::size_t slot = 0;  // of the sender's accounts
  bool wants_history = false;
  bool is_in_group = false;  // a member of the session's multicast group
};
using Subscribers = core::FixedVector<Subscriber, kMaxSubscribers>;

// What a writer has sent to one reader: the messages first .. last, whatever became of them. Written by the thread that
// sends.
struct SpanAccount {
  std::atomic<std::uint64_t> instance{0};  // of the reader; 0: none yet
  std::atomic<std::uint64_t> first{0};
  std::atomic<std::uint64_t> last{0};
};

// Whether a datagram's envelope names that node as its sender; nothing else is checked.
bool IsFromNode(std::uint32_t node, std::span<const std::uint8_t> datagram) noexcept;

// A datagram sent by ZeroMQ instead of UDP, to these instances (latest_ways.cpp).
struct DetouredDatagram {
  std::array<std::uint8_t, kMaxDatagramBytes> bytes;
  std::size_t size = 0;
  core::FixedVector<std::uint64_t, kMaxSubscribers> readers;
};
using Detour = SpscRing<DetouredDatagram>;
constexpr std::size_t kDetourCapacity = 64;  // 64 ms of a 1 kHz topic while the bus thread is held up

struct LatestSender {
  LatestSender(std::string topic_name, MessageType message_type);
  virtual ~LatestSender() = default;
  // Bus thread: the readers from now on; at most kMaxSubscribers. Sets their slots.
  void SetReaders(const Subscribers& readers);

  std::string topic;
  MessageType type;
  Envelope envelope;  // all but the header is set once
  const UdpSocket* socket = nullptr;
  sockaddr_in group{};             // address of the session's multicast group
  std::unique_ptr<Detour> detour;  // null: it goes by UDP
  int wake_fd = -1;                // of the bus thread, for the detour
  DatagramGuard* guard = nullptr;
  log::Tap* tap = nullptr;  // null: none
  std::uint16_t tap_slot = log::Tap::kNoSlot;
  LatestValue<Subscribers> subscribers;  // bus thread -> the thread that sends
  std::uint64_t sequence = 0;
  EarlierSamples earlier;
  std::array<SpanAccount, kMaxSubscribers> spans;
  std::array<std::uint64_t, kMaxSubscribers> slots{};  // instance that holds the slot; bus thread
  std::atomic<std::uint64_t> sent{0};
  std::atomic<std::uint64_t> dropped{0};

 protected:
  void CountFor(const Subscriber& reader) noexcept;
  // To every reader. Returns a bit for each reader for which the socket refused it; adds the accepted ones to
  // *datagrams.
  std::uint64_t SendToAll(const Subscribers& readers, std::span<const std::uint8_t> datagram, int* datagrams) noexcept;

 private:
  bool PutOnDetour(const Subscribers& readers, std::span<const std::uint8_t> datagram) noexcept;
};

template <class M>
struct TypedSender final : LatestSender {
  explicit TypedSender(const std::string& topic_name) : LatestSender(topic_name, kMessageTypeOf<M>) {}
  int Send(M* message) noexcept;

 private:
  // One part, ready to go; 0: it does not fit, or nobody reads it but the tap.
  std::size_t WriteDatagram(const M& message, std::uint8_t* bytes) noexcept;
  LatestCodec<M> codec_;
};

// Whenever nothing is under way: meant = received + restored + dropped, for each writer and reader.
struct LatestCounts {
  std::uint64_t meant = 0;      // by the sequences that arrived or that the writer reported
  std::uint64_t received = 0;   // each message once, late ones included
  std::uint64_t restored = 0;   // came with a later one's datagram only
  std::uint64_t dropped = 0;    // lost on the way, or too late to be distinguished from a duplicate
  std::uint64_t reordered = 0;  // arrived after a newer one
  std::uint64_t repeated = 0;   // duplicates
};

constexpr std::int64_t kUnknownClock = INT64_MIN;

struct LatestReceiver {
  LatestReceiver(std::string topic_name, MessageType message_type);
  virtual ~LatestReceiver() = default;
  // Earlier samples stand behind `payload`.
  virtual Refusal Take(const Envelope& envelope, std::span<const std::uint8_t> payload,
                       std::int64_t now_ns) noexcept = 0;
  virtual void ClearFresh() noexcept = 0;
  [[nodiscard]] virtual bool keeps_history() const noexcept = 0;

  // Bus thread: the writer reports that it has sent first .. last to this reader.
  void TakeReport(std::uint64_t writer_boot, std::uint64_t first, std::uint64_t last,
                  std::uint64_t instance = 0) noexcept;
  // Bus thread: the writer is gone and reports no more. What it reported and is not here counts as lost until it comes.
  void Settle() noexcept;
  [[nodiscard]] LatestCounts Counts() const noexcept;  // any thread
  // Of the writer's latest reported life. Any thread.
  [[nodiscard]] LatestLife Life() const noexcept;

  std::string topic;
  MessageType type;
  log::Tap* tap = nullptr;  // null: none
  std::uint16_t tap_slot = log::Tap::kNoSlot;
  std::uint32_t id;
  std::uint32_t digest;
  // The writer's clock minus this node's; kUnknownClock: another machine's, not compared yet.
  std::atomic<std::int64_t> clock_offset_ns{0};
  std::atomic<std::uint32_t> other_digest{0};  // of a writer whose schema the registry found compatible

 protected:
  void Publish() noexcept;  // the counts, for other threads
  void CountStraggler() noexcept { ++past_.reordered; }
  void Restart(std::uint64_t new_boot) noexcept;

  SequenceTracker tracker;
  std::uint64_t boot = 0;  // of the life of the writer that is being read

 private:
  struct Tally {
    std::uint64_t meant = 0, received = 0, restored = 0, lost = 0, reordered = 0, repeated = 0;
  };
  // Counts of the life of the writer that is being read, and of all earlier ones together.
  struct Seen {
    std::uint64_t boot = 0, first = 0, newest = 0;
    Tally present, past;
  };
  Tally past_;  // step thread
  Published<Seen> seen_;
  // The writer's reports of its last two lives: when the later life reports before its first message arrives, losses at
  // the end of the earlier one still count. `settled` is the last sequence reported one heartbeat ago: by now that
  // message is here or lost.
  struct WriterReport {
    std::atomic<std::uint64_t> boot{0}, first{0}, last{0}, settled{0}, instance{0};
  };
  std::array<WriterReport, 2> reported_;
  // Over the life that is being read and later ones: first .. reported.*last, less what the tracker accounts for.
  std::uint64_t UnseenOfOpenLives(const Seen& seen, std::atomic<std::uint64_t> WriterReport::*last) const noexcept;
};

struct LatestAccess {
  template <class M>
  static void SetMaxAge(LatestReader<M>* reader, std::int64_t max_age_ns) {
    reader->max_age_ns_ = max_age_ns;
  }
  template <class M>
  static void ClearFresh(LatestReader<M>* reader) {
    reader->is_fresh_ = false;
  }
  template <class M>
  static M& Staging(LatestReader<M>* reader) {
    return reader->staging_;
  }
  // The slot of that sequence in the history; null: too old, or no history.
  template <class M>
  static M* Place(LatestReader<M>* reader, std::uint64_t sequence, std::uint64_t newest) {
    const std::size_t size = reader->history_.size();
    return size == 0 || sequence + size <= newest ? nullptr : &reader->history_[sequence % size];
  }
  template <class M>
  static void Restart(LatestReader<M>* reader) {
    ++reader->restarts_;
    for (M& sample : reader->history_) sample.header.sequence = 0;
  }
  template <class M>
  static void Accept(LatestReader<M>* reader, std::int64_t now_ns) {
    reader->value_ = reader->staging_;
    reader->received_ns_ = now_ns;
    reader->is_fresh_ = true;
  }
};

template <class M>
struct TypedReceiver final : LatestReceiver {
  explicit TypedReceiver(const std::string& topic_name, std::int64_t max_age_ns);
  Refusal Take(const Envelope& envelope, std::span<const std::uint8_t> payload, std::int64_t now_ns) noexcept override;
  void ClearFresh() noexcept override { LatestAccess::ClearFresh(&reader); }
  [[nodiscard]] bool keeps_history() const noexcept override { return reader.keeps_history(); }

  LatestReader<M> reader;

 private:
  Refusal TakeNewer(const Envelope& envelope, std::span<const std::uint8_t> payload, std::int64_t now_ns) noexcept;
  void TakeOlder(const Envelope& envelope, std::span<const std::uint8_t> payload) noexcept;
  void TakeEarlier(std::uint64_t sequence, std::span<const std::uint8_t> blocks) noexcept;
  bool Keep(const core::Header& header, std::span<const std::uint8_t> payload) noexcept;

  LatestCodec<M> codec_;
  std::uint64_t staging_sequence_ = 0;
  std::uint64_t staging_parts_ = 0;  // bit per part that has arrived
};

}  // namespace bus::detail
