#include <array>

#include "bus/wire/codec.hpp"
#include "bus/wire/envelope.hpp"
#include "tests/fuzz/claim.hpp"
#include "tests/fuzz/reader.hpp"

namespace fuzz {
namespace {

constexpr std::size_t kBudget = bus::kMaxDatagramBytes - bus::kEnvelopeFixedBytes;

// Decodes all parts into one message, as a receiver does; the message must survive encoding and decoding.
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

// Checks the message type of that index among M. False if there are fewer.
template <class... M>
struct CheckLatest {
  static bool Run(std::size_t index, const Reader& reader) {
    std::size_t i = 0;
    return ((i++ == index && (Check<M>(reader), true)) || ...);
  }
  static constexpr std::size_t kCount = sizeof...(M);
};
template <class... M>
struct CheckReliable {
  static bool Run(std::size_t index, const std::string& bytes) {
    std::size_t i = 0;
    return ((i++ == index && (CheckState<M>(bytes), true)) || ...);
  }
  static constexpr std::size_t kCount = sizeof...(M);
};
using Latest = bus::LatestMessages<CheckLatest>;
using Reliable = bus::ReliableMessages<CheckReliable>;

}  // namespace

// The first byte selects the message type; the parts, or the bytes of a value, follow.
void FuzzLatestCodec(Input input) {
  Reader reader(input);
  const std::size_t index = reader.Byte() % (Latest::kCount + Reliable::kCount);
  if (!Latest::Run(index, reader)) Reliable::Run(index - Latest::kCount, TextOf(reader.Rest()));
}

}  // namespace fuzz
