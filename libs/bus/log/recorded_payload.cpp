#include "bus/log/recorded_payload.hpp"

#include <algorithm>
#include <array>

namespace bus::log {
namespace {

constexpr std::uint32_t kTag = kEnvelopeField << 3 | 2;  // length-delimited
constexpr std::size_t kTagBytes = 2;
static_assert(kTag < 1 << 14 && kTag >= 1 << 7);
static_assert(kMaxEnvelopeBytes + 1 < 1 << 14, "the length fits two bytes");

// Always two bytes, so that the position of everything can be computed from the end.
std::array<std::uint8_t, 2> Varint2(std::uint32_t value) {
  return {static_cast<std::uint8_t>(0x80 | (value & 0x7f)), static_cast<std::uint8_t>(value >> 7)};
}

}  // namespace

void AppendEnvelope(const Envelope& as_sent, Bytes* recorded) {
  // Without what belongs to transport only (seal, earlier samples).
  Envelope envelope;
  envelope.topic_class = as_sent.topic_class;
  envelope.part = as_sent.part;
  envelope.num_parts = as_sent.num_parts;
  envelope.topic = as_sent.topic;
  envelope.schema_digest = as_sent.schema_digest;
  envelope.session = as_sent.session;
  envelope.node = as_sent.node;
  envelope.boot = as_sent.boot;
  envelope.header = as_sent.header;
  // As on the wire, followed by the payload: the checksum covers both.
  const std::size_t size = EnvelopeBytes(envelope.header);
  Bytes datagram(size + recorded->size());
  std::copy(recorded->begin(), recorded->end(), datagram.begin() + static_cast<std::ptrdiff_t>(size));
  WriteEnvelope(envelope, recorded->size(), datagram.data());
  const auto tag = Varint2(kTag);
  const auto length = Varint2(static_cast<std::uint32_t>(size + 1));
  recorded->insert(recorded->end(), tag.begin(), tag.end());
  recorded->insert(recorded->end(), length.begin(), length.end());
  recorded->insert(recorded->end(), datagram.begin(), datagram.begin() + static_cast<std::ptrdiff_t>(size));
  recorded->push_back(static_cast<std::uint8_t>((size - kEnvelopeFixedBytes) / kStampBytes));
}

RecordedPayload SplitRecorded(std::span<const std::uint8_t> recorded) {
  RecordedPayload split;
  split.payload = recorded;
  if (recorded.empty()) return split;
  const std::size_t size = kEnvelopeFixedBytes + kStampBytes * recorded.back();
  const std::size_t extra = 2 * kTagBytes + size + 1;
  if (extra > recorded.size()) return split;
  const auto field = recorded.last(extra);
  const auto tag = Varint2(kTag);
  const auto length = Varint2(static_cast<std::uint32_t>(size + 1));
  if (!std::equal(tag.begin(), tag.end(), field.begin())) return split;
  if (!std::equal(length.begin(), length.end(), field.begin() + kTagBytes)) return split;
  // As it was on the wire: the checksum covers both.
  Bytes datagram(field.begin() + 2 * kTagBytes, field.end() - 1);
  const auto payload = recorded.first(recorded.size() - extra);
  datagram.insert(datagram.end(), payload.begin(), payload.end());
  std::span<const std::uint8_t> parsed;
  if (ReadEnvelope(datagram, &split.envelope, &parsed) != EnvelopeStatus::kOk || parsed.size() != payload.size()) {
    return split;
  }
  split.payload = payload;
  split.has_envelope = true;
  return split;
}

}  // namespace bus::log
