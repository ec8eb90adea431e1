#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace fuzz {

// Blocks that FuzzBulk offers and fetches, and that its seeds are about: of one chunk, and of one and a bit.
inline std::vector<std::uint8_t> SmallBlock() {
  constexpr std::string_view kText = "mesh";
  return {kText.begin(), kText.end()};
}

inline std::vector<std::uint8_t> LargeBlock() {
  std::vector<std::uint8_t> bytes(std::size_t{64} << 10, 'v');
  const std::vector<std::uint8_t> end = SmallBlock();
  bytes.insert(bytes.end(), end.begin(), end.end());
  return bytes;
}

}  // namespace fuzz
