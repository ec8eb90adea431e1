#include "picture/flip.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace picture {
namespace {

constexpr int kSize = 48;

Image Uniform(const std::array<std::uint8_t, 3>& rgb) {
  Image image(kSize, kSize);
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    std::copy(rgb.begin(), rgb.end(), image.rgba.begin() + static_cast<std::ptrdiff_t>(i));
    image.rgba[i + 3] = 255;
  }
  return image;
}

Image Noise(unsigned seed) {
  Image image(kSize, kSize);
  for (std::uint8_t& value : image.rgba)
    value = static_cast<std::uint8_t>((seed = seed * 1664525u + 1013904223u) >> 24);
  return image;
}

TEST(Flip, IsZeroForIdenticalPictures) {
  const Image image = Noise(7);
  EXPECT_EQ(Mean(Flip(image, image)), 0.0);
}

// The filters leave a uniform picture as it is, and it has no edges, so what remains is the colours' difference.
TEST(Flip, IsOneForTheTwoColoursThatDifferMost) {
  EXPECT_NEAR(Mean(Flip(Uniform({0, 255, 0}), Uniform({0, 0, 255}))), 1.0, 1e-6);
}

// HyAB of black and white is 100, their lightness. The greatest, of green and blue, is 203.3 after Hunt's adjustment of
// CIELAB's (87.74, -86.18, 83.18) and (32.30, 79.19, -107.86); to the power of 0.7 that is 41.28 (0.4 of it: 16.51).
// So 0.95 + 0.05 (100^0.7 - 16.51) / (41.28 - 16.51).
TEST(Flip, OfBlackAndWhiteIsTheLightnessesDifference) {
  EXPECT_NEAR(Mean(Flip(Uniform({0, 0, 0}), Uniform({255, 255, 255}))), 0.9674, 1e-4);
}

// Grey 119 has lightness 50.03 and grey 122 has 51.21: 1.18^0.7 = 1.123, and 0.95 / 16.51 of it.
TEST(Flip, OfTwoNearGreysIsOnTheSteepPart) {
  EXPECT_NEAR(Mean(Flip(Uniform({119, 119, 119}), Uniform({122, 122, 122}))), 0.0646, 5e-4);
}

TEST(Flip, IsTheSameBothWaysRound) {
  const Image a = Noise(1), b = Noise(2);
  EXPECT_EQ(Flip(a, b).values, Flip(b, a).values);
}

TEST(Flip, NoticesAPixelMoreThanItsColourAndOnlyNearIt) {
  Image with = Uniform({90, 90, 90});
  for (int k = 0; k < 3; ++k) with.Pixel(24, 24)[k] = 255;
  const Measured<float> map = Flip(Uniform({90, 90, 90}), with);
  EXPECT_GT(*map.Pixel(24, 24), 0.3f);
  EXPECT_LT(*map.Pixel(2, 2), 1e-3f);
  EXPECT_EQ(std::max_element(map.values.begin(), map.values.end()) - map.values.begin(), 24 * kSize + 24);
}

// A checkerboard of single pixels is finer than the eye resolves: seen as its mean, but for the features.
TEST(Flip, DoesNotSeeWhatTheEyeCannotResolve) {
  Image board = Uniform({0, 0, 0}), inverse = Uniform({0, 0, 0});
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      for (int k = 0; k < 3; ++k) ((x + y) % 2 == 0 ? board : inverse).Pixel(x, y)[k] = 255;
    }
  }
  const Measured<float> map = Flip(board, inverse);
  EXPECT_LT(*map.Pixel(24, 24), 0.02f);
  EXPECT_GT(*Flip(board, inverse, 10.0).Pixel(24, 24), 0.3f) << "from nearby";
}

TEST(Flip, TheMeanOverAMaskLeavesTheRestOut) {
  Measured<float> map(2, 1);
  map.values = {0.25f, 1.0f};
  Measured<std::uint16_t> mask(2, 1);
  EXPECT_EQ(Mean(map, mask), 0.0);
  mask.values = {3, 0};
  EXPECT_EQ(Mean(map, mask), 0.25);
  EXPECT_EQ(Mean(map), 0.625);
}

}  // namespace
}  // namespace picture
