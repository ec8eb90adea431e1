#include "bus/log/tap_points.hpp"

#include <algorithm>
#include <array>

#include "bus/node_core.hpp"
#include "bus/wire/encode.hpp"
#include "bus/wire/schema.hpp"
#include "core/clock.hpp"
#include "proto/bus.pb.h"

namespace bus::detail {
namespace {

constexpr const char* kAckTopic = "param/ack";

// Cuts texts, so that the size of a message is bounded.
class CuttingWriter : public WireWriter {
 public:
  using WireWriter::WireWriter;
  void Text(std::uint32_t number, std::string_view text) { WireWriter::Text(number, text.substr(0, kMaxEventText)); }
};

template <class M>
constexpr std::size_t MaxCutBytes() {
  std::size_t bytes = 0;
  core::ForEachField<M>([&bytes](auto field) {
    using F = decltype(field);
    bytes += TagBytes(F::kNumber);
    if constexpr (F::kWire == Wire::kString) {
      bytes += VarintBytes(kMaxEventText) + kMaxEventText;
    } else {
      bytes += MaxValueBytes<F::kWire, typename F::Type>();
    }
  });
  return bytes;
}

// Encodes a small message without allocation.
template <std::size_t capacity>
class SmallMessage {
 public:
  template <class Write>
  explicit SmallMessage(Write&& write) {
    CuttingWriter writer(bytes_.data());
    write(&writer);
    size_ = static_cast<std::size_t>(writer.end() - bytes_.data());
  }
  [[nodiscard]] std::span<const std::uint8_t> bytes() const { return std::span(bytes_).first(size_); }

 private:
  std::array<std::uint8_t, capacity> bytes_;
  std::size_t size_ = 0;
};

template <class M>  // core::Event or core::ParameterChange
auto Encode(const M& message) {
  return SmallMessage<MaxCutBytes<M>()>([&message](CuttingWriter* writer) { WriteFields(message, {}, writer); });
}

template <class Answer>  // ParameterAnswer or ParameterAck, as oos.ParameterReply
auto EncodeReply(std::uint64_t request, const Answer& answer) {
  constexpr std::size_t kNumberBytes = 11;
  return SmallMessage<5 * kNumberBytes + 4 + kMaxEventText>([&](CuttingWriter* writer) {
    WriteNumberField<Wire::kUint64>(1, request, writer);
    WriteNumberField<Wire::kBool>(2, answer.is_accepted, writer);
    WriteNumberField<Wire::kUint64>(3, answer.tick, writer);
    if (!answer.why.empty()) writer->Text(4, answer.why);
    WriteNumberField<Wire::kDouble>(5, answer.injected_J, writer);
    WriteNumberField<Wire::kBool>(6, answer.is_pending, writer);
  });
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
