#pragma once

#include <bit>
#include <cstdint>

#include "bus/log/recorded_payload.hpp"
#include "bus/wire/codec.hpp"

namespace bus::log {

// Assembles the messages of one recorded LATEST topic from their parts.
template <class M>
class RecordedMessage {
 public:
  // Null until the last part of a message has come, or when it cannot be decoded. Valid until the next call.
  const M* Take(const RecordedPayload& part) {
    const Envelope& envelope = part.envelope;
    const bool is_whole = !part.has_envelope || envelope.num_parts == 1;
    const bool is_first = is_whole || parts_ == 0 || envelope.boot != boot_ || envelope.header.sequence != sequence_;
    if (!codec_.Decode(part.payload, is_first, &message_)) {
      parts_ = 0;
      return nullptr;
    }
    if (is_first) parts_ = 0;
    boot_ = envelope.boot;
    sequence_ = envelope.header.sequence;
    if (part.has_envelope) message_.header = envelope.header;
    if (!is_whole) {
      parts_ |= std::uint64_t{1} << (envelope.part & 63U);
      if (std::popcount(parts_) != envelope.num_parts) return nullptr;
    }
    parts_ = 0;
    return &message_;
  }
  // After Take returned null: true if parts are still missing, false if it could not be decoded.
  [[nodiscard]] bool is_incomplete() const { return parts_ != 0; }

 private:
  LatestCodec<M> codec_;
  M message_;
  std::uint64_t boot_ = 0;
  std::uint64_t sequence_ = 0;
  std::uint64_t parts_ = 0;  // bit per part that has arrived; 0: none is awaited
};

}  // namespace bus::log
