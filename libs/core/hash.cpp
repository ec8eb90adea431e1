#include "core/hash.hpp"

#include <xxhash.h>
#include <zlib.h>

#if defined(__x86_64__)
#include <immintrin.h>

#include <array>
#endif

namespace core {
namespace {

#if defined(__x86_64__)

constexpr std::array<std::uint32_t, 16> MakeNibbleTable() {
  std::array<std::uint32_t, 16> table{};
  for (std::uint32_t i = 0; i < 16; ++i) {
    table[i] = i;
    for (int bit = 0; bit < 4; ++bit) table[i] = (table[i] >> 1) ^ ((table[i] & 1) != 0 ? 0xedb88320 : 0);
  }
  return table;
}

// For the few bytes that are no block: a table of one cache line.
std::uint32_t ShortCrc32(const std::uint8_t* data, std::size_t num_bytes, std::uint32_t previous) {
  static constexpr std::array<std::uint32_t, 16> kTable = MakeNibbleTable();
  std::uint32_t crc = ~previous;
  for (std::size_t i = 0; i < num_bytes; ++i) {
    crc ^= data[i];
    crc = kTable[crc & 15] ^ (crc >> 4);
    crc = kTable[crc & 15] ^ (crc >> 4);
  }
  return ~crc;
}

// CRC-32 by carry-less multiplication [Gopal et al., Fast CRC Computation for Generic Polynomials Using PCLMULQDQ,
// Intel 2009], for a whole number of blocks of 16 bytes, at least one. Without tables: a datagram now and then does not
// find them in the cache. The message is a polynomial over GF(2), bits reflected. One block is folded into the next by
//
//   x * 2^128 = low(x) * (2^(128+32) mod P) + high(x) * (2^(128-32) mod P)  (mod P),
//
// the last 128 bits are reduced to 64 and to 32 the same way, and Barrett's reduction does the rest:
// R = x - P * floor(x * mu / 2^64), with mu = floor(2^64 / P).
[[gnu::target("pclmul,sse4.1")]] std::uint32_t FoldedCrc32(const std::uint8_t* data, std::size_t num_bytes,
                                                           std::uint32_t previous) {
  const auto load = [](const std::uint8_t* at) { return _mm_loadu_si128(reinterpret_cast<const __m128i*>(at)); };
  const __m128i fold_128 = _mm_set_epi64x(0x00ccaa009e, 0x01751997d0);
  const __m128i fold_64 = _mm_set_epi64x(0, 0x0163cd6124);
  const __m128i barrett = _mm_set_epi64x(0x01f7011641, 0x01db710641);  // mu, P
  const __m128i low_words = _mm_setr_epi32(-1, 0, -1, 0);

  __m128i x = _mm_xor_si128(load(data), _mm_cvtsi32_si128(static_cast<int>(~previous)));
  for (std::size_t at = 16; at < num_bytes; at += 16) {
    const __m128i low = _mm_clmulepi64_si128(x, fold_128, 0x00);
    const __m128i high = _mm_clmulepi64_si128(x, fold_128, 0x11);
    x = _mm_xor_si128(_mm_xor_si128(low, high), load(data + at));
  }
  x = _mm_xor_si128(_mm_srli_si128(x, 8), _mm_clmulepi64_si128(x, fold_128, 0x10));
  x = _mm_xor_si128(_mm_srli_si128(x, 4), _mm_clmulepi64_si128(_mm_and_si128(x, low_words), fold_64, 0x00));
  __m128i q = _mm_clmulepi64_si128(_mm_and_si128(x, low_words), barrett, 0x10);
  q = _mm_clmulepi64_si128(_mm_and_si128(q, low_words), barrett, 0x00);
  return ~static_cast<std::uint32_t>(_mm_extract_epi32(_mm_xor_si128(x, q), 1));
}

#endif

}  // namespace

std::uint64_t Hash64(const void* data, std::size_t num_bytes, std::uint64_t seed) {
  return XXH3_64bits_withSeed(data, num_bytes, seed);
}

std::uint32_t Crc32(const void* data, std::size_t num_bytes, std::uint32_t previous) {
  const auto* bytes = static_cast<const std::uint8_t*>(data);
#if defined(__x86_64__)
  static const bool has_multiplication = __builtin_cpu_supports("pclmul") != 0 && __builtin_cpu_supports("sse4.1") != 0;
  if (has_multiplication) {
    const std::size_t blocks = num_bytes / 16 * 16;
    if (blocks != 0) previous = FoldedCrc32(bytes, blocks, previous);
    return ShortCrc32(bytes + blocks, num_bytes - blocks, previous);
  }
#endif
  return static_cast<std::uint32_t>(crc32_z(previous, bytes, num_bytes));
}

}  // namespace core
