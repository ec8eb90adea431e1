#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>

#include "tests/fuzz/targets.hpp"

namespace fuzz {

// Cuts an input into numbers and pieces; after its end numbers are zero and pieces empty.
class Reader {
 public:
  explicit Reader(Input input) : rest_(input) {}

  [[nodiscard]] bool is_at_end() const { return rest_.empty(); }
  std::uint8_t Byte() {
    if (rest_.empty()) return 0;
    const std::uint8_t byte = rest_.front();
    rest_ = rest_.subspan(1);
    return byte;
  }
  // A piece with its length in the two bytes before it, cut at the input's end.
  Input Piece() {
    const std::size_t low = Byte();
    const std::size_t size_claimed = low | std::size_t{Byte()} << 8;
    const std::size_t size = std::min(size_claimed, rest_.size());
    const Input piece = rest_.first(size);
    rest_ = rest_.subspan(size);
    return piece;
  }
  Input Rest() const { return rest_; }

 private:
  Input rest_;
};

inline std::string TextOf(Input bytes) {
  return {bytes.begin(), bytes.end()};
}

}  // namespace fuzz
