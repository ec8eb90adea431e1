#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "bus/log/mcap_records.hpp"
#include "bus/wire/envelope.hpp"

namespace bus::log {

// A recorded LATEST payload is followed by its envelope (unsealed, without history), so that a recording can be
// replayed exactly: traces, parts, the writer's start. The envelope is a protobuf field with a number that no schema
// uses, so every reader skips it:
//
//   payload | tag 2047, bytes | length | envelope | u8 number of stamps in the envelope
//
// The last byte is part of the field: read backwards, it gives the start of the envelope.
constexpr std::uint32_t kEnvelopeField = 2047;

// `recorded` holds the payload.
void AppendEnvelope(const Envelope& envelope, Bytes* recorded);

struct RecordedPayload {
  std::span<const std::uint8_t> payload;
  bool has_envelope = false;
  Envelope envelope;
};

// Splits payload and envelope. Without an envelope, or with a wrong checksum: has_envelope is false, and `payload`
// holds all bytes.
RecordedPayload SplitRecorded(std::span<const std::uint8_t> recorded);

}  // namespace bus::log
