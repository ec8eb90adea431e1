#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "bus/figures.hpp"
#include "bus/topics.hpp"

namespace bus {

// Returned when a payload does not fit. (A message of default values takes 0 bytes.)
constexpr std::size_t kDoesNotFit = ~std::size_t{0};

// Payload of one LATEST message, in one or more parts. Does not allocate. `header` is the envelope's and is neither
// read nor written here.
template <class M>
class LatestCodec {
 public:
  // Parts needed so that each payload stays within `budget` bytes.
  [[nodiscard]] int NumParts(const M& message, std::size_t budget) const noexcept;
  // Returns the payload's size, or kDoesNotFit.
  std::size_t Encode(const M& message, int part, std::size_t budget, std::uint8_t* out,
                     std::size_t capacity) const noexcept;
  // Adds one part to `message`. `is_first`: the first part of this message to arrive; resizes the lists. False, with
  // `message` unchanged, when the bytes are not such a payload or are inconsistent.
  bool Decode(std::span<const std::uint8_t> payload, bool is_first, M* message) const noexcept;
};

// Values of STATE topics, events and parameter changes. EncodeState replaces the content of `bytes`; it allocates only
// when the capacity is too small.
template <class M>
void EncodeState(const M& value, std::string* bytes);
// False, with `value` unchanged, when the bytes are not such a value.
template <class M>
bool DecodeState(const std::string& bytes, M* value);

}  // namespace bus
