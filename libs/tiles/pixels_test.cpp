#include "tiles/pixels.hpp"

#include <gtest/gtest.h>

#include <random>

namespace tiles {
namespace {

TEST(Pixels, LightIsOffByAHalfStepOfItsBrightestChannel) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> exponent(-8.0f, 8.0f), share(0.0f, 1.0f);
  for (int i = 0; i < 20'000; ++i) {
    const float most = std::exp2(exponent(random));
    const glm::vec3 light = most * glm::vec3(1.0f, share(random), share(random));
    const glm::vec3 error = glm::abs(UnpackLight(PackLight(light)) - light);
    EXPECT_LE(std::max(error.r, std::max(error.g, error.b)), most / 512.0f) << most;
  }
}

TEST(Pixels, LightRoundsUpToTheNextExponent) {
  EXPECT_EQ(UnpackLight(PackLight(glm::vec3(0.9999f))), glm::vec3(1.0f));
  EXPECT_EQ(UnpackLight(PackLight(glm::vec3(0.0f))), glm::vec3(0.0f));
  EXPECT_EQ(UnpackLight(PackLight(glm::vec3(1e9f))), glm::vec3(65408.0f)) << "the largest that the format holds";
  EXPECT_EQ(UnpackLight(PackLight(glm::vec3(-1.0f, 2.0f, 0.0f))), glm::vec3(0.0f, 2.0f, 0.0f));
}

TEST(Pixels, DepthIsOffByTheSameShareNearAndFar) {
  for (float depth_m = kNearest_m; depth_m < kFarthest_m; depth_m *= 1.0007f) {
    EXPECT_NEAR(UnpackDepth(PackDepth(depth_m)), depth_m, 7e-5f * depth_m);
  }
  EXPECT_EQ(PackDepth(0.0f), 0) << "nothing is there";
  EXPECT_EQ(UnpackDepth(0), 0.0f);
  EXPECT_NE(PackDepth(0.5f * kNearest_m), 0);
}

// A tile of 5 x 3 in a larger canvas, with runs that end within rows and at their ends.
class TileOfPixels : public testing::Test {
 protected:
  TileOfPixels() {
    canvas_.Resize(12, 8);
    std::fill(canvas_.light.begin(), canvas_.light.end(), 7u);
    std::fill(canvas_.depth.begin(), canvas_.depth.end(), std::uint16_t{9});
    for (const int at : {1, 2, 5, 6, 7, 8, 9, 14}) {
      depth_m_[static_cast<std::size_t>(at)] = 1.0f + 0.1f * static_cast<float>(at);
      for (std::size_t k = 0; k < 3; ++k)
        light_[3 * static_cast<std::size_t>(at) + k] = 0.25f * static_cast<float>(k + 1);
    }
    bytes_ = EncodePixels(tile_, light_, depth_m_);
  }
  [[nodiscard]] static std::size_t At(int x, int y) { return static_cast<std::size_t>(12 * y + x); }

  const Tile tile_{4, 2, 5, 3};
  std::vector<float> light_ = std::vector<float>(45, 0.0f);
  std::vector<float> depth_m_ = std::vector<float>(15, 0.0f);
  std::string bytes_;
  Canvas canvas_;
};

TEST_F(TileOfPixels, ArrivesAtItsPlaceAndNowhereElse) {
  ASSERT_TRUE(DecodePixels(bytes_, tile_, &canvas_));
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 12; ++x) {
      const bool is_inside = x >= 4 && x < 9 && y >= 2 && y < 5;
      if (!is_inside) {
        EXPECT_EQ(canvas_.light[At(x, y)], 7u) << x << " " << y;
        EXPECT_EQ(canvas_.depth[At(x, y)], 9) << x << " " << y;
        continue;
      }
      const auto from = static_cast<std::size_t>(5 * (y - 2) + x - 4);
      EXPECT_EQ(canvas_.depth[At(x, y)], PackDepth(depth_m_[from])) << x << " " << y;
      const glm::vec3 light(light_[3 * from], light_[3 * from + 1], light_[3 * from + 2]);
      EXPECT_EQ(canvas_.light[At(x, y)], depth_m_[from] > 0.0f ? PackLight(light) : 0u) << x << " " << y;
    }
  }
}

TEST_F(TileOfPixels, WhatIsCutOrTooLongOrOfAnotherSizeIsRefused) {
  for (std::size_t size = 0; size < bytes_.size(); ++size) {
    EXPECT_FALSE(DecodePixels(bytes_.substr(0, size), tile_, &canvas_)) << size;
  }
  EXPECT_FALSE(DecodePixels(bytes_ + "x", tile_, &canvas_));
  EXPECT_FALSE(DecodePixels(bytes_, {4, 2, 5, 2}, &canvas_));
  EXPECT_FALSE(DecodePixels(bytes_, {8, 2, 5, 3}, &canvas_)) << "reaches beyond the canvas";
}

TEST_F(TileOfPixels, EmptyPixelsCostNothing) {
  const std::vector<float> nothing(15, 0.0f);
  EXPECT_EQ(EncodePixels(tile_, light_, nothing).size(), 4u);
}

}  // namespace
}  // namespace tiles
