#include "device/cobs.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace device {
namespace {

std::vector<std::vector<std::uint8_t>> FramesIn(const std::vector<std::uint8_t>& stream) {
  std::vector<std::vector<std::uint8_t>> frames;
  Unstuffer unstuffer;
  for (const std::uint8_t byte : stream) {
    if (unstuffer.Take(byte)) frames.emplace_back(unstuffer.bytes().begin(), unstuffer.bytes().end());
  }
  return frames;
}

std::vector<std::uint8_t> Stuffed(const std::vector<std::uint8_t>& bytes) {
  std::array<std::uint8_t, kMaxStuffed> out{};
  const std::size_t size = Stuff(bytes, out);
  return {out.begin(), out.begin() + static_cast<std::ptrdiff_t>(size)};
}

// The examples of the paper.
TEST(Cobs, StuffsAsPublished) {
  EXPECT_EQ(Stuffed({0x00}), (std::vector<std::uint8_t>{1, 1, 0}));
  EXPECT_EQ(Stuffed({0x11, 0x22, 0x00, 0x33}), (std::vector<std::uint8_t>{3, 0x11, 0x22, 2, 0x33, 0}));
  EXPECT_EQ(Stuffed({0x11, 0x00, 0x00, 0x00}), (std::vector<std::uint8_t>{2, 0x11, 1, 1, 1, 0}));
}

TEST(Cobs, AnyFrameComesBackFromTheMiddleOfAnyStream) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 3000; ++i) {
    std::vector<std::uint8_t> frame(1 + random() % kMaxFrameSize);
    const bool has_zeros = random() % 2 == 0;
    for (auto& byte : frame) byte = static_cast<std::uint8_t>(has_zeros && random() % 3 == 0 ? 0 : 1 + random() % 255);
    std::vector<std::uint8_t> stream(random() % 600);
    for (auto& byte : stream) byte = static_cast<std::uint8_t>(random());
    stream.push_back(0);
    const std::vector<std::uint8_t> stuffed = Stuffed(frame);
    stream.insert(stream.end(), stuffed.begin(), stuffed.end());
    const auto frames = FramesIn(stream);
    ASSERT_FALSE(frames.empty());
    ASSERT_EQ(frames.back(), frame);
  }
}

TEST(Cobs, AFrameThatIsTooLongIsLeftOutAndTheNextOneFound) {
  std::vector<std::uint8_t> stream(1000, 0x07);
  stream.push_back(0);
  for (const std::uint8_t byte : Stuffed({1, 2, 3})) stream.push_back(byte);
  const auto frames = FramesIn(stream);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0], (std::vector<std::uint8_t>{1, 2, 3}));
}

}  // namespace
}  // namespace device
