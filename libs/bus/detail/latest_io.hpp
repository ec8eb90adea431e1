#pragma once

#include <netinet/in.h>

#include <atomic>
#include <cstdint>
#include <span>
#include <string>

#include "bus/codec.hpp"
#include "bus/detail/udp_socket.hpp"
#include "bus/envelope.hpp"
#include "bus/latest.hpp"
#include "bus/log/tap.hpp"
#include "bus/rt/latest_value.hpp"
#include "core/fixed_vector.hpp"

namespace bus::detail {

// Who this node is, in every envelope that it sends.
struct Identity {
  std::uint64_t session = 0;
  std::uint32_t node = 0;
  std::uint64_t boot = 0;
};

constexpr std::size_t kMaxSubscribers = 16;
using Subscribers = core::FixedVector<sockaddr_in, kMaxSubscribers>;

struct LatestSender {
  LatestSender(std::string topic_name, MessageType message_type);
  virtual ~LatestSender() = default;

  std::string topic;
  MessageType type;
  Envelope envelope;  // all but the header is set once
  const UdpSocket* socket = nullptr;
  log::Tap* tap = nullptr;  // null: none
  std::uint16_t tap_slot = log::Tap::kNoSlot;
  LatestValue<Subscribers> subscribers;  // bus thread -> the thread that sends
  std::uint64_t sequence = 0;
  std::atomic<std::uint64_t> sent{0};
  std::atomic<std::uint64_t> dropped{0};
};

template <class M>
struct TypedSender final : LatestSender {
  explicit TypedSender(const std::string& topic_name) : LatestSender(topic_name, kMessageTypeOf<M>) {}
  int Send(M* message) noexcept;
  LatestCodec<M> codec;
};

// Follows one topic's sequence: tells what is new, what came late, what is lost. Window of 64 messages.
class SequenceTracker {
 public:
  enum class Verdict { kNew, kLate, kRepeated };
  Verdict Take(std::uint64_t sequence);  // of a complete message
  void Restart() { *this = SequenceTracker{}; }
  [[nodiscard]] std::uint64_t newest() const { return newest_; }
  [[nodiscard]] std::int64_t lost_by_last() const {
    return lost_by_last_;
  }  // change of the loss count; -1: it came after all

 private:
  std::uint64_t newest_ = 0;
  std::uint64_t seen_ = 0;  // bit i: newest - i has arrived
  std::int64_t lost_by_last_ = 0;
};

struct LatestReceiver {
  LatestReceiver(std::string topic_name, MessageType message_type);
  virtual ~LatestReceiver() = default;
  // False: refused (wrong schema or not decodable).
  virtual bool Take(const Envelope& envelope, std::span<const std::uint8_t> payload, std::int64_t now_ns) noexcept = 0;
  virtual void ClearFresh() noexcept = 0;

  std::string topic;
  MessageType type;
  log::Tap* tap = nullptr;  // null: none
  std::uint16_t tap_slot = log::Tap::kNoSlot;
  std::uint32_t id;
  std::uint32_t digest;
  std::atomic<std::uint32_t> other_digest{0};  // of a writer whose schema the registry found compatible
  std::atomic<std::uint64_t> received{0};
  std::atomic<std::uint64_t> dropped{0};
  std::atomic<std::uint64_t> reordered{0};
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
  template <class M>
  static void CountRestart(LatestReader<M>* reader) {
    ++reader->restarts_;
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
  bool Take(const Envelope& envelope, std::span<const std::uint8_t> payload, std::int64_t now_ns) noexcept override;
  void ClearFresh() noexcept override;

  LatestReader<M> reader;
  LatestCodec<M> codec;
  SequenceTracker tracker;
  std::uint64_t boot = 0;
  std::uint64_t staging_sequence = 0;
  std::uint64_t staging_parts = 0;  // bit per part that has arrived
};

}  // namespace bus::detail
