#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "bus/envelope.hpp"
#include "bus/log/mcap_records.hpp"

namespace bus::log {

// A recorded LATEST payload is followed by the envelope that it travelled in (unsealed, without history), so that a
// recording can be played back as it was: traces, parts, the writer's start. It is one more protobuf field of a number
// that no schema has, which every reader skips:
//
//   payload | tag 2047, bytes | length | envelope | u8 number of stamps in the envelope
//
// The last byte is within the field: it tells from behind where the envelope begins.
constexpr std::uint32_t kEnvelopeField = 2047;

// `recorded` holds the payload.
void AppendEnvelope(const Envelope& envelope, Bytes* recorded);

struct RecordedPayload {
  std::span<const std::uint8_t> payload;
  bool has_envelope = false;
  Envelope envelope;
};

// Takes the two apart. Without an envelope, or with one whose checksum does not fit: has_envelope is false and the
// payload is all of it.
RecordedPayload SplitRecorded(std::span<const std::uint8_t> recorded);

}  // namespace bus::log
