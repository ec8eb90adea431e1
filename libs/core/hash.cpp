#include "core/hash.hpp"

#include <xxhash.h>
#include <zlib.h>

namespace core {

std::uint64_t Hash64(const void* data, std::size_t num_bytes, std::uint64_t seed) {
  return XXH3_64bits_withSeed(data, num_bytes, seed);
}

std::uint32_t Crc32(const void* data, std::size_t num_bytes, std::uint32_t previous) {
  return static_cast<std::uint32_t>(crc32_z(previous, static_cast<const Bytef*>(data), num_bytes));
}

}  // namespace core
