#include "bus/wire/envelope.hpp"

#include <cstring>
#include <vector>

#include "core/hash.hpp"
#include "tests/fuzz/claim.hpp"
#include "tests/fuzz/targets.hpp"

namespace fuzz {
namespace {

constexpr std::size_t kFlagsAt = 30;
constexpr std::size_t kHistoryMask = 0x07ff;
constexpr std::size_t kLengthAt = 56;
constexpr std::size_t kChecksumAt = 60;

void Check(Input bytes) {
  bus::Envelope envelope;
  Input payload;
  if (bus::ReadEnvelope(bytes, &envelope, &payload) != bus::EnvelopeStatus::kOk) {
    Claim(!bus::ParseEnvelope(bytes).has_value(), "both readers refuse");
    return;
  }
  const std::size_t head = bus::EnvelopeBytes(envelope.header);
  Claim(head + payload.size() <= bytes.size() && payload.data() == bytes.data() + head, "the payload is inside");
  std::vector<std::uint8_t> again(bytes.begin(), bytes.end());
  std::memset(again.data(), 0, head);
  Claim(bus::WriteEnvelope(envelope, payload.size(), again.data()) == bytes.size() &&
            std::memcmp(again.data(), bytes.data(), bytes.size()) == 0,
        "an envelope that was read is written with the same bytes");
}

}  // namespace

// The input unchanged, and with its length and checksum corrected, to reach the code behind the checksum.
void FuzzEnvelope(Input input) {
  Check(input);
  if (input.size() < bus::kEnvelopeFixedBytes) return;
  std::vector<std::uint8_t> corrected(input.begin(), input.end());
  const std::size_t head = bus::kEnvelopeFixedBytes + bus::kStampBytes * (std::size_t{corrected[28]} + corrected[29]);
  std::uint16_t flags = 0;
  std::memcpy(&flags, &corrected[kFlagsAt], sizeof(flags));
  const std::size_t history = flags & kHistoryMask;
  if (corrected.size() < head + history) return;
  const auto length = static_cast<std::uint32_t>(corrected.size() - head - history);
  std::memcpy(&corrected[kLengthAt], &length, sizeof(length));
  const std::uint32_t front = core::Crc32(corrected.data(), kChecksumAt);
  const std::uint32_t crc = core::Crc32(corrected.data() + kChecksumAt + 4, corrected.size() - kChecksumAt - 4, front);
  std::memcpy(&corrected[kChecksumAt], &crc, sizeof(crc));
  Check(corrected);
}

}  // namespace fuzz
