#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace core {

// xxHash3, 64 bit: content addresses of cached structures, state hashes of runs.
std::uint64_t Hash64(const void* data, std::size_t num_bytes, std::uint64_t seed = 0);
inline std::uint64_t Hash64(std::string_view text, std::uint64_t seed = 0) {
  return Hash64(text.data(), text.size(), seed);
}

// CRC-32 (IEEE 802.3, as zlib): checksum of wire envelopes and files.
std::uint32_t Crc32(const void* data, std::size_t num_bytes, std::uint32_t previous = 0);

}  // namespace core
