#include "view/appearance/mip_levels.hpp"

#include <gtest/gtest.h>

namespace view {
namespace {

// Black and white columns, half transparent rows.
vps::VisualTexture Stripes(int width, int height, bool is_color) {
  vps::VisualTexture picture{width, height, {}, is_color};
  for (int i = 0; i < width * height; ++i) {
    const auto grey = static_cast<std::uint8_t>(i % width % 2 == 0 ? 0 : 255);
    const auto alpha = static_cast<std::uint8_t>(i / width % 2 == 0 ? 255 : 55);
    picture.rgba.insert(picture.rgba.end(), {grey, grey, grey, alpha});
  }
  return picture;
}

TEST(MipLevels, GoDownToOneTexel) {
  const std::vector<MipLevel> levels = MipLevels(Stripes(8, 2, true));
  ASSERT_EQ(levels.size(), 4u);
  for (std::size_t i = 0; i < levels.size(); ++i) {
    EXPECT_EQ(levels[i].width, 8 >> i);
    EXPECT_EQ(levels[i].height, i == 0 ? 2 : 1);
    EXPECT_EQ(levels[i].texels.size(), static_cast<std::size_t>(levels[i].width * levels[i].height));
  }
}

TEST(MipLevels, MixTheLightOfColoursAndTheCodesOfNumbers) {
  const std::vector<MipLevel> colors = MipLevels(Stripes(4, 4, true)), numbers = MipLevels(Stripes(4, 4, false));
  for (const glm::u8vec4& texel : colors[1].texels) {
    EXPECT_EQ(texel, glm::u8vec4(188, 188, 188, 155)) << "sRGB of half the light";
  }
  for (const glm::u8vec4& texel : numbers[1].texels) EXPECT_EQ(texel, glm::u8vec4(128, 128, 128, 155));
}

}  // namespace
}  // namespace view
