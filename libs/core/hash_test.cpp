#include "core/hash.hpp"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cstdint>
#include <random>
#include <vector>

namespace core {
namespace {

TEST(Crc32, MatchesTheStandardCheckValueAndZlibForEverySizeAndStart) {
  EXPECT_EQ(Crc32("123456789", 9), 0xcbf43926u);
  EXPECT_EQ(Crc32("", 0), 0u);
  std::mt19937_64 random(2);
  std::vector<std::uint8_t> bytes(2000);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
  for (std::size_t size = 0; size < 600; ++size) {
    const std::size_t first = random() % 1000;
    const auto previous = static_cast<std::uint32_t>(size % 3 == 0 ? 0 : random());
    ASSERT_EQ(Crc32(&bytes[first], size, previous), crc32_z(previous, &bytes[first], size)) << size;
  }
  EXPECT_EQ(Crc32(&bytes[700], 1300, Crc32(bytes.data(), 700)), Crc32(bytes.data(), 2000));
}

}  // namespace
}  // namespace core
