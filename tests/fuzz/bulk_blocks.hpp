#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace fuzz {

// The blocks of FuzzBulk and its seeds: one that fits into a chunk and one that does not.
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
