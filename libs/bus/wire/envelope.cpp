#include "bus/wire/envelope.hpp"

#include <bit>
#include <cstring>
#include <string>

#include "core/hash.hpp"

namespace bus {
namespace {

static_assert(std::endian::native == std::endian::little, "the envelope is copied as it stands in memory");

template <class T>
void Put(std::uint8_t* out, std::size_t at, T value) {
  std::memcpy(out + at, &value, sizeof(T));
}

template <class T>
T Get(const std::uint8_t* in, std::size_t at) {
  T value;
  std::memcpy(&value, in + at, sizeof(T));
  return value;
}

constexpr std::size_t kChecksumAt = 60;
constexpr std::uint16_t kSealedBit = 0x8000;
constexpr std::uint16_t kHistoryMask = 0x07ff;
static_assert(kMaxDatagramBytes <= kHistoryMask);

std::uint32_t Checksum(const std::uint8_t* bytes, std::size_t size) {
  const std::uint32_t head = core::Crc32(bytes, kChecksumAt);
  return core::Crc32(bytes + kChecksumAt + 4, size - kChecksumAt - 4, head);
}

std::size_t PutStamps(const core::Trace& trace, std::uint8_t* out, std::size_t at) {
  for (const core::Stamp& stamp : trace.stamps) {
    Put(out, at, stamp.offset_ns);
    Put(out, at + 4, static_cast<std::uint8_t>(stamp.stage));
    at += kStampBytes;
  }
  return at;
}

std::size_t GetStamps(const std::uint8_t* in, std::size_t at, std::size_t count, core::Trace* trace) {
  trace->stamps.clear();
  for (std::size_t i = 0; i < count; ++i, at += kStampBytes) {
    trace->stamps.push_back({static_cast<core::Stage>(in[at + 4]), Get<std::int32_t>(in, at)});
  }
  return at;
}

}  // namespace

std::size_t EnvelopeBytes(const core::Header& header) {
  return kEnvelopeFixedBytes + kStampBytes * (header.direct.stamps.size() + header.through_physics.stamps.size());
}

std::size_t WriteEnvelopeToSeal(const Envelope& envelope, std::size_t payload_bytes, std::uint8_t* out) noexcept {
  const core::Header& header = envelope.header;
  Put(out, 0, kEnvelopeMagic);
  out[4] = kEnvelopeVersion;
  out[5] = static_cast<std::uint8_t>(envelope.topic_class);
  out[6] = envelope.part;
  out[7] = envelope.num_parts;
  Put(out, 8, envelope.topic);
  Put(out, 12, envelope.schema_digest);
  Put(out, 16, envelope.session);
  Put(out, 24, envelope.node);
  out[28] = static_cast<std::uint8_t>(header.direct.stamps.size());
  out[29] = static_cast<std::uint8_t>(header.through_physics.stamps.size());
  Put(out, 30, envelope.history_bytes);
  Put(out, 32, envelope.boot);
  Put(out, 40, header.sequence);
  Put(out, 48, header.publish_ns);
  Put(out, 56, static_cast<std::uint32_t>(payload_bytes));
  Put(out, 64, header.direct.id);
  Put(out, 72, header.direct.origin_ns);
  Put(out, 80, header.through_physics.id);
  Put(out, 88, header.through_physics.origin_ns);
  std::size_t at = PutStamps(header.direct, out, kEnvelopeFixedBytes);
  at = PutStamps(header.through_physics, out, at);
  return at + payload_bytes + envelope.history_bytes;
}

std::size_t WriteEnvelope(const Envelope& envelope, std::size_t payload_bytes, std::uint8_t* out) noexcept {
  const std::size_t size = WriteEnvelopeToSeal(envelope, payload_bytes, out);
  Put(out, kChecksumAt, Checksum(out, size));
  return size;
}

void MarkSealed(std::uint8_t* bytes) noexcept {
  Put(bytes, 30, static_cast<std::uint16_t>(Get<std::uint16_t>(bytes, 30) | kSealedBit));
  Put(bytes, kChecksumAt, std::uint32_t{0});
}

EnvelopeStatus ReadEnvelopeFields(std::span<const std::uint8_t> bytes, Envelope* envelope,
                                  std::span<const std::uint8_t>* payload) noexcept {
  const std::uint8_t* in = bytes.data();
  if (bytes.size() < kEnvelopeFixedBytes) return EnvelopeStatus::kTooShort;
  if (Get<std::uint32_t>(in, 0) != kEnvelopeMagic) return EnvelopeStatus::kBadMagic;
  if (in[4] != kEnvelopeVersion) return EnvelopeStatus::kBadVersion;
  const std::size_t direct_stamps = in[28];
  const std::size_t other_stamps = in[29];
  const auto flags = Get<std::uint16_t>(in, 30);
  const bool is_class_known =
      in[5] >= static_cast<std::uint8_t>(TopicClass::kLatest) && in[5] <= static_cast<std::uint8_t>(TopicClass::kBulk);
  if (!is_class_known || in[7] == 0 || in[6] >= in[7] || direct_stamps > core::kMaxStamps ||
      other_stamps > core::kMaxStamps || (flags & ~(kSealedBit | kHistoryMask)) != 0) {
    return EnvelopeStatus::kBadField;
  }
  const std::size_t head = kEnvelopeFixedBytes + kStampBytes * (direct_stamps + other_stamps);
  const std::size_t payload_bytes = Get<std::uint32_t>(in, 56);
  envelope->is_sealed = (flags & kSealedBit) != 0;
  envelope->history_bytes = flags & kHistoryMask;
  const std::size_t seal_bytes = envelope->is_sealed ? kSealBytes : 0;
  if (bytes.size() != head + payload_bytes + envelope->history_bytes + seal_bytes) return EnvelopeStatus::kBadLength;

  envelope->topic_class = static_cast<TopicClass>(in[5]);
  envelope->part = in[6];
  envelope->num_parts = in[7];
  envelope->topic = Get<std::uint32_t>(in, 8);
  envelope->schema_digest = Get<std::uint32_t>(in, 12);
  envelope->session = Get<std::uint64_t>(in, 16);
  envelope->node = Get<std::uint32_t>(in, 24);
  envelope->boot = Get<std::uint64_t>(in, 32);
  core::Header& header = envelope->header;
  header.sequence = Get<std::uint64_t>(in, 40);
  header.publish_ns = Get<std::int64_t>(in, 48);
  header.direct.id = Get<std::uint64_t>(in, 64);
  header.direct.origin_ns = Get<std::int64_t>(in, 72);
  header.through_physics.id = Get<std::uint64_t>(in, 80);
  header.through_physics.origin_ns = Get<std::int64_t>(in, 88);
  const std::size_t at = GetStamps(in, kEnvelopeFixedBytes, direct_stamps, &header.direct);
  GetStamps(in, at, other_stamps, &header.through_physics);
  *payload = bytes.subspan(head, payload_bytes);
  return EnvelopeStatus::kOk;
}

EnvelopeStatus ReadEnvelope(std::span<const std::uint8_t> bytes, Envelope* envelope,
                            std::span<const std::uint8_t>* payload) noexcept {
  const EnvelopeStatus status = ReadEnvelopeFields(bytes, envelope, payload);
  if (status != EnvelopeStatus::kOk) return status;
  if (envelope->is_sealed) return EnvelopeStatus::kSealed;
  const bool is_sound = Get<std::uint32_t>(bytes.data(), kChecksumAt) == Checksum(bytes.data(), bytes.size());
  return is_sound ? EnvelopeStatus::kOk : EnvelopeStatus::kBadChecksum;
}

const char* Describe(EnvelopeStatus status) {
  switch (status) {
    case EnvelopeStatus::kOk:
      return "sound";
    case EnvelopeStatus::kTooShort:
      return "shorter than an envelope";
    case EnvelopeStatus::kBadMagic:
      return "not from this bus (magic differs)";
    case EnvelopeStatus::kBadVersion:
      return "another envelope version; build all nodes from one source";
    case EnvelopeStatus::kBadField:
      return "a field is out of range";
    case EnvelopeStatus::kBadLength:
      return "length differs from the length written inside";
    case EnvelopeStatus::kBadChecksum:
      return "checksum differs";
    case EnvelopeStatus::kSealed:
      return "encrypted, and this reader has no keys";
  }
  return "unknown";
}

core::Result<Message> ParseEnvelope(std::span<const std::uint8_t> bytes) {
  Message message;
  const EnvelopeStatus status = ReadEnvelope(bytes, &message.envelope, &message.payload);
  if (status == EnvelopeStatus::kOk) return message;
  return core::Fail(core::ErrorCode::kDamaged,
                    "envelope of " + std::to_string(bytes.size()) + " bytes refused: " + Describe(status));
}

}  // namespace bus
