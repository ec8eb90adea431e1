#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "bus/topics.hpp"
#include "core/messages/trace.hpp"
#include "core/result.hpp"

namespace bus {

// Every message on the wire is an envelope and a protobuf payload (decision D8). The envelope is read without parsing
// the payload. Fixed little endian:
//
//    0 u32 magic "VOOS"     24 u32 node (hash of its name)         64 u64 direct trace id
//    4 u8  version          28 u8  stamps of the direct trace      72 i64 direct trace origin [ns]
//    5 u8  class            29 u8  stamps of the other             80 u64 through-physics trace id
//    6 u8  part             30 u16 sealed, history bytes           88 i64 through-physics trace origin [ns]
//    7 u8  number of parts  32 u64 boot                            96 stamps, 5 bytes each: i32 offset [ns], u8 stage
//    8 u32 topic id         40 u64 sequence                           then the payload, then earlier samples
//   12 u32 schema digest    48 i64 publish time [ns]                  (latest/history.hpp), then the seal
//   16 u64 session          56 u32 payload bytes
//                           60 u32 CRC-32 of everything but itself; 0 in a sealed datagram
//
// The u16 at 30: bit 15: sealed (security/sealing.hpp), bits 0-10 are the bytes of earlier samples.
constexpr std::uint32_t kEnvelopeMagic = 0x534f'4f56;
constexpr std::uint8_t kEnvelopeVersion = 1;
constexpr std::size_t kEnvelopeFixedBytes = 96;
constexpr std::size_t kStampBytes = 5;
constexpr std::size_t kMaxEnvelopeBytes = kEnvelopeFixedBytes + 2 * core::kMaxStamps * kStampBytes;
// Fits the smallest usual MTU (1280, IPv6) minus IP, UDP and VPN headers.
constexpr std::size_t kMaxDatagramBytes = 1200;
constexpr std::size_t kSealBytes = 24;  // counter and tag behind a sealed datagram

struct Envelope {
  TopicClass topic_class = TopicClass::kLatest;
  std::uint8_t part = 0;
  std::uint8_t num_parts = 1;
  std::uint32_t topic = 0;
  std::uint32_t schema_digest = 0;
  std::uint64_t session = 0;
  std::uint32_t node = 0;
  std::uint64_t boot = 0;           // epoch: grows with each start of the node
  bool is_sealed = false;           // everything after the stamps is encrypted, all is authenticated
  std::uint16_t history_bytes = 0;  // of earlier samples, after the payload
  core::Header header;
};

// Bytes before the payload.
std::size_t EnvelopeBytes(const core::Header& header);

// Writes the envelope in front of a payload and history that are already at out + EnvelopeBytes(header). Returns the
// total size. `is_sealed` is ignored.
std::size_t WriteEnvelope(const Envelope& envelope, std::size_t payload_bytes, std::uint8_t* out) noexcept;

// The same without a checksum, for datagrams that are sealed next; MarkSealed sets the bit.
std::size_t WriteEnvelopeToSeal(const Envelope& envelope, std::size_t payload_bytes, std::uint8_t* out) noexcept;
void MarkSealed(std::uint8_t* bytes) noexcept;

enum class EnvelopeStatus : std::uint8_t {
  kOk,
  kTooShort,
  kBadMagic,
  kBadVersion,
  kBadField,
  kBadLength,
  kBadChecksum,
  kSealed
};

// For the real-time path: no exception, no allocation, whatever the bytes. `payload` points into `bytes`; the earlier
// samples follow it. Refuses sealed datagrams, which detail::Opener reads.
EnvelopeStatus ReadEnvelope(std::span<const std::uint8_t> bytes, Envelope* envelope,
                            std::span<const std::uint8_t>* payload) noexcept;

// The same without checking checksum or seal: only that the fields fit the size.
EnvelopeStatus ReadEnvelopeFields(std::span<const std::uint8_t> bytes, Envelope* envelope,
                                  std::span<const std::uint8_t>* payload) noexcept;

const char* Describe(EnvelopeStatus status);

struct Message {
  Envelope envelope;
  std::span<const std::uint8_t> payload;  // a view of the given bytes
};

// The same with a readable error.
core::Result<Message> ParseEnvelope(std::span<const std::uint8_t> bytes);

}  // namespace bus
