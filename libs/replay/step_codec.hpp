#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace replay {

// Every field as 64 bits, and back: an exact image, also of a NaN.
template <class T>
std::uint64_t BitsOf(const T& value) {
  if constexpr (std::is_same_v<T, double>) {
    return std::bit_cast<std::uint64_t>(value);
  } else if constexpr (std::is_same_v<T, float>) {
    return std::bit_cast<std::uint32_t>(value);
  } else if constexpr (std::is_signed_v<T>) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(value));
  } else {
    return static_cast<std::uint64_t>(value);
  }
}

template <class T>
T FromBits(std::uint64_t bits) {
  if constexpr (std::is_same_v<T, double>) {
    return std::bit_cast<double>(bits);
  } else if constexpr (std::is_same_v<T, float>) {
    return std::bit_cast<float>(static_cast<std::uint32_t>(bits));
  } else {
    return static_cast<T>(bits);
  }
}

// A step of a node as bytes (little endian):
//
//    0 u8  1: key step, complete in itself; 0: omitted fields have the values of the step before
//    1 u8  kind of step; each kind has a step before of its own
//    2 u8[2] 0
//    4 u32 number of fields
//    8 u64 tick
//   16 u64 digest of the outputs (OutputDigest)
//   24 one bit per field, least significant first: 1 if present
//      then the present fields: a byte w and the lowest w bytes of its 64 bits, exclusive or those of the step
//      before (neighbours in time share sign, exponent and first digits, so the upper bytes are zero)
//
// Fields are identified by position: where lists grow or shrink, positions shift, which costs bytes but never
// exactness. The predecessor of a field beyond the step before, and of every field in a key step, is zero.
constexpr std::size_t kStepHeadBytes = 24;

// A node with several kinds of step records them in one order; each kind has its encoder and its decoder.
constexpr std::uint8_t kUsualStep = 0;
inline std::uint8_t StepKind(std::span<const std::uint8_t> step) {
  return step.size() > 1 ? step[1] : kUsualStep;
}

class StepEncoder {
 public:
  static constexpr bool kReads = false;
  static constexpr std::uint64_t kKeyPeriod =
      500;  // steps between key steps: 0.5 s at 1 kHz to decode before a step; adds 1/500 of a key step to each

  // `max_fields`: a step with more is refused. All memory is allocated here.
  explicit StepEncoder(std::size_t max_fields, std::uint8_t kind = kUsualStep);

  void Begin(std::uint64_t tick);
  // The step's bytes, valid until the next Begin; empty when it had too many fields (the next one is complete then).
  [[nodiscard]] std::span<const std::uint8_t> Finish(std::uint64_t digest);
  // The last step was lost: the next one becomes a key step.
  void Forget() { is_key_next_ = true; }

  template <class T>
  void Value(std::string_view, T& value) {
    Put(BitsOf(value));
  }
  void Text(std::string_view, std::string& text);
  std::size_t Count(std::string_view, std::size_t count) {
    Put(count);
    return count;
  }
  void Enter(std::string_view) {}
  void Enter(std::string_view, std::size_t) {}
  void Leave() {}

  bool includes_transport = true;

 private:
  void Put(std::uint64_t bits) {
    const std::size_t i = num_fields_++;
    if (i >= last_.size()) return;
    const std::uint64_t change = bits ^ (is_key_ || i >= last_fields_ ? 0 : last_[i]);
    last_[i] = bits;
    if (change == 0) return;
    flags_[i / 8] |= static_cast<std::uint8_t>(1U << (i % 8));
    const unsigned used = (71U - static_cast<unsigned>(std::countl_zero(change))) / 8U;
    values_[num_value_bytes_] = static_cast<std::uint8_t>(used);
    std::memcpy(&values_[num_value_bytes_ + 1], &change, sizeof change);
    num_value_bytes_ += 1 + used;
  }

  std::vector<std::uint64_t> last_;
  std::vector<std::uint8_t> flags_, values_, step_;
  std::size_t num_fields_ = 0, last_fields_ = 0, num_value_bytes_ = 0;
  std::uint64_t since_key_ = 0;
  bool is_key_ = true, is_key_next_ = true;
  std::uint8_t kind_ = kUsualStep;
  std::uint64_t tick_ = 0;
};

// Reads steps in the order in which they were written.
class StepDecoder {
 public:
  static constexpr bool kReads = true;

  // False: damaged, or the first step is not a key step.
  bool Begin(std::span<const std::uint8_t> step);
  // True when all fields were read, no more and no fewer.
  [[nodiscard]] bool Finish();
  [[nodiscard]] std::uint64_t tick() const { return tick_; }
  [[nodiscard]] std::uint64_t digest() const { return digest_; }

  template <class T>
  void Value(std::string_view, T& value) {
    value = FromBits<T>(Take());
  }
  void Text(std::string_view, std::string& text);
  std::size_t Count(std::string_view, std::size_t) {
    const std::uint64_t count = Take();
    if (count <= last_.size()) return static_cast<std::size_t>(count);  // a list has a field per item at least
    Fail();
    return 0;
  }
  void Enter(std::string_view) {}
  void Enter(std::string_view, std::size_t) {}
  void Leave() {}
  void Fail() { is_damaged_ = true; }

  bool includes_transport = true;

 private:
  std::uint64_t Take();

  std::vector<std::uint64_t> last_;
  std::span<const std::uint8_t> flags_, values_;
  std::size_t next_ = 0, at_ = 0;
  std::uint64_t tick_ = 0, digest_ = 0;
  bool is_damaged_ = false;
  bool has_key_ = false;
};

}  // namespace replay
