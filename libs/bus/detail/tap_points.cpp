#include "bus/detail/tap_points.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include "bus/detail/node_core.hpp"
#include "bus/schema.hpp"
#include "core/clock.hpp"
#include "proto/bus.pb.h"

namespace bus::detail {
namespace {

constexpr const char* kAckTopic = "param/ack";

// A small protobuf message without an allocation: fields of proto/logic.proto and proto/bus.proto by their numbers.
// Values of 0 and empty texts are left out, as proto3 does.
class Encoder {
 public:
  void Number(unsigned field, std::uint64_t value) {
    if (value == 0) return;
    Varint(field << 3);
    Varint(value);
  }
  void Signed(unsigned field, std::int64_t value) {  // sint64: zigzag
    Number(field, static_cast<std::uint64_t>(value) << 1 ^ static_cast<std::uint64_t>(value >> 63));
  }
  void Real(unsigned field, double value) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    if (bits == 0) return;
    Varint(field << 3 | 1);
    for (unsigned i = 0; i < 8; ++i) Byte(static_cast<std::uint8_t>(bits >> 8 * i));
  }
  void Text(unsigned field, const std::string& text) {
    const std::size_t size = std::min(text.size(), kMaxEventText);
    if (size == 0) return;
    Varint(field << 3 | 2);
    Varint(size);
    for (std::size_t i = 0; i < size; ++i) Byte(static_cast<std::uint8_t>(text[i]));
  }
  [[nodiscard]] std::span<const std::uint8_t> bytes() const { return std::span(bytes_).first(size_); }

 private:
  void Varint(std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) Byte(static_cast<std::uint8_t>(value | 0x80));
    Byte(static_cast<std::uint8_t>(value));
  }
  void Byte(std::uint8_t value) { bytes_[size_++] = value; }
  std::array<std::uint8_t, 3 * (kMaxEventText + 4) + 64> bytes_;  // three texts and some numbers
  std::size_t size_ = 0;
};

Encoder Encode(const core::Event& event) {
  Encoder e;
  e.Signed(1, event.time_ns);
  e.Text(2, event.source);
  e.Text(3, event.name);
  e.Text(4, event.detail);
  return e;
}

Encoder Encode(const core::ParameterChange& change) {
  Encoder e;
  e.Text(1, change.name);
  e.Real(2, change.value);
  e.Number(3, static_cast<std::uint64_t>(change.manner));
  e.Real(4, change.ramp_s);
  return e;
}

template <class Answer>  // ParameterAnswer or ParameterAck
Encoder EncodeReply(std::uint64_t request, const Answer& answer) {
  Encoder e;
  e.Number(1, request);
  e.Number(2, answer.is_accepted ? 1 : 0);
  e.Number(3, answer.tick);
  e.Text(4, answer.why);
  e.Real(5, answer.injected_J);
  e.Number(6, answer.is_pending ? 1 : 0);
  return e;
}

std::span<const std::uint8_t> BytesOf(std::span<const char> text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

}  // namespace

std::vector<log::PeerClock> ClocksOf(const std::vector<PeerStatus>& peers) {
  std::vector<log::PeerClock> clocks;
  for (const PeerStatus& peer : peers) {
    if (!peer.is_alive || peer.clock_bound_ns == INT64_MAX) continue;
    clocks.push_back({peer.name, {}, peer.clock_offset_ns, peer.clock_bound_ns, peer.clock_drift_ppm * 1e-6});
  }
  return clocks;
}

void TapPoints::Attach(log::Tap* tap) {
  tap_ = tap;
  if (tap_ == nullptr) return;
  using log::TapKind;
  events_out_ = Declare(TapKind::kSent, kEventTopic, TopicClass::kEvent, MessageType::kEvent);
  events_in_ = Declare(TapKind::kTaken, kEventTopic, TopicClass::kEvent, MessageType::kEvent);
  calls_ = Declare(TapKind::kSent, kParameterTopic, TopicClass::kService, MessageType::kParameterChange);
  parameters_ = Declare(TapKind::kTaken, kParameterTopic, TopicClass::kService, MessageType::kParameterChange);
  const auto& reply = *oos::ParameterReply::descriptor();
  for (const TapKind kind : {TapKind::kSent, TapKind::kTaken}) {
    (kind == TapKind::kSent ? answers_ : acks_) =
        tap_->AddTopic({kind, kAckTopic, TopicClass::kService, reply.full_name(), DescriptorSetOf(reply)});
  }
}

std::uint16_t TapPoints::Declare(log::TapKind kind, const std::string& topic, TopicClass topic_class,
                                 MessageType type) {
  if (tap_ == nullptr) return log::Tap::kNoSlot;
  return tap_->AddTopic({kind, topic, topic_class, SchemaOf(type).name, DescriptorSetOf(type)});
}

void TapPoints::DeclareStateWriter(const std::string& topic, MessageType type) {
  state_writers_.push_back(Declare(log::TapKind::kSent, topic, TopicClass::kState, type));
}

void TapPoints::DeclareStateReader(const std::string& topic, MessageType type) {
  state_readers_.push_back(Declare(log::TapKind::kTaken, topic, TopicClass::kState, type));
}

void TapPoints::WroteState(std::uint32_t slot, const std::string& key, std::span<const char> bytes) noexcept {
  ++num_states_;
  if (tap_ == nullptr) return;
  const std::int64_t now_ns = core::MonotonicNow_ns();
  tap_->Put(state_writers_[slot], num_states_, now_ns, now_ns, BytesOf(key), BytesOf(bytes));
}

void TapPoints::TookState(const StateItem& item) noexcept {
  if (tap_ == nullptr || item.is_reset) return;  // a reset has no value
  tap_->Put(state_readers_[item.slot], item.version, core::MonotonicNow_ns(), 0, BytesOf(item.key),
            BytesOf(item.bytes));
}

void TapPoints::Emitted(const core::Event& event) noexcept {
  if (tap_ == nullptr) return;
  const std::int64_t now_ns = core::MonotonicNow_ns();
  tap_->Put(events_out_, ++num_emitted_, now_ns, now_ns, {}, Encode(event).bytes());
}

void TapPoints::TookEvent(const core::Event& event) noexcept {
  if (tap_ == nullptr) return;
  tap_->Put(events_in_, ++num_heard_, core::MonotonicNow_ns(), 0, {}, Encode(event).bytes());
}

void TapPoints::Posted(std::uint64_t request, const std::string& owner, const core::ParameterChange& change) noexcept {
  if (tap_ == nullptr) return;
  const std::int64_t now_ns = core::MonotonicNow_ns();
  tap_->Put(calls_, request, now_ns, now_ns, BytesOf(owner), Encode(change).bytes());
}

void TapPoints::TookParameter(std::uint64_t ticket, const core::ParameterChange& change) noexcept {
  if (tap_ == nullptr) return;
  tap_->Put(parameters_, ticket, core::MonotonicNow_ns(), 0, {}, Encode(change).bytes());
}

void TapPoints::Answered(const ParameterAnswer& answer) noexcept {
  if (tap_ == nullptr) return;
  const std::int64_t now_ns = core::MonotonicNow_ns();
  tap_->Put(answers_, answer.ticket, now_ns, now_ns, {}, EncodeReply(answer.ticket, answer).bytes());
}

void TapPoints::TookAck(const ParameterAck& ack) noexcept {
  if (tap_ == nullptr) return;
  tap_->Put(acks_, ack.request, core::MonotonicNow_ns(), 0, BytesOf(ack.owner), EncodeReply(ack.request, ack).bytes());
}

}  // namespace bus::detail
