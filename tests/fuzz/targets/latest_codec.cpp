#include <array>

#include "bus/codec.hpp"
#include "bus/envelope.hpp"
#include "tests/fuzz/claim.hpp"
#include "tests/fuzz/quiet_protobuf.hpp"
#include "tests/fuzz/reader.hpp"

namespace fuzz {
namespace {

constexpr std::size_t kBudget = bus::kMaxDatagramBytes - bus::kEnvelopeFixedBytes;

// Every part goes into one message, as a receiver does it; then the message is sent on and must arrive.
template <class M>
void Check(Reader input) {
  static bus::LatestCodec<M> codec;
  static M message;
  static M again;
  bool is_first = true;
  bool is_whole = false;
  while (!input.is_at_end()) {
    if (codec.Decode(input.Piece(), is_first, &message)) is_first = false, is_whole = true;
  }
  if (!is_whole) return;
  const int parts = codec.NumParts(message, kBudget);
  Claim(parts >= 1 && parts <= 255, "a message that arrived can be sent on");
  std::array<std::uint8_t, kBudget> bytes;
  for (int part = 0; part < parts; ++part) {
    const std::size_t size = codec.Encode(message, part, kBudget, bytes.data(), bytes.size());
    Claim(size <= kBudget, "a part fits its datagram");
    Claim(codec.Decode({bytes.data(), size}, part == 0, &again), "a part that was written can be read");
  }
}

template <class M>
void CheckState(const std::string& bytes) {
  M value;
  if (!bus::DecodeState(bytes, &value)) return;
  std::string written;
  bus::EncodeState(value, &written);
  M again;
  Claim(bus::DecodeState(written, &again), "a value that was written can be read");
}

}  // namespace

// The first byte tells the message; then come parts.
void FuzzLatestCodec(Input input) {
  QuietProtobuf();
  Reader reader(input);
  switch (reader.Byte() % 9) {
    case 0:
      return Check<core::DeviceState>(reader);
    case 1:
      return Check<core::DeviceCommand>(reader);
    case 2:
      return Check<core::HapticProxy>(reader);
    case 3:
      return Check<core::ContactSet>(reader);
    case 4:
      return Check<core::PhysicsState>(reader);
    case 5:
      return Check<core::Reaction>(reader);
    case 6:
      return Check<core::SheetState>(reader);
    case 7:
      return CheckState<core::LogicStatus>(TextOf(reader.Rest()));
    case 8:
      return CheckState<bus::Figures>(TextOf(reader.Rest()));
  }
}

}  // namespace fuzz
