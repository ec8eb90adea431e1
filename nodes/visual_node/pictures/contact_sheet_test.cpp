#include "nodes/visual_node/pictures/contact_sheet.hpp"

#include <gtest/gtest.h>

namespace visual_node {
namespace {

Image Plain(std::uint8_t red) {
  Image image(64, 36);
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    image.rgba[i] = red;
    image.rgba[i + 3] = 255;
  }
  return image;
}

TEST(ContactSheet, TilesAreInTheOrderOfTheSteps) {
  ContactSheet sheet;
  for (int i = 0; i < 4; ++i) sheet.Add("step_" + std::to_string(i), Plain(static_cast<std::uint8_t>(60 * i + 40)));
  const auto image = sheet.Compose();
  ASSERT_TRUE(image) << image.error().detail;
  EXPECT_EQ(image->width, 3 * (64 + 8) + 8);
  const int row = image->height / 2;
  for (int i = 0; i < 3; ++i) EXPECT_EQ(image->Pixel(8 + i * 72 + 32, 8 + 18)[0], 60 * i + 40);
  EXPECT_EQ(image->Pixel(8 + 32, row + 18)[0], 220);  // the fourth starts a second row
}

TEST(ContactSheet, NamesAreWrittenBelow) {
  ContactSheet sheet;
  sheet.Add("cover", Plain(0));
  const auto image = sheet.Compose();
  ASSERT_TRUE(image) << image.error().detail;
  int bright = 0;
  for (int y = 8 + 36; y < image->height; ++y) {
    for (int x = 0; x < image->width; ++x) bright += image->Pixel(x, y)[1] > 150;
  }
  EXPECT_GT(bright, 30);
}

TEST(ContactSheet, AStepEnteredAgainKeepsItsPlace) {
  ContactSheet sheet;
  sheet.Add("a", Plain(10));
  sheet.Add("b", Plain(20));
  sheet.Add("a", Plain(30));
  EXPECT_EQ(sheet.size(), 2u);
  const auto image = sheet.Compose();
  ASSERT_TRUE(image) << image.error().detail;
  EXPECT_EQ(image->Pixel(8 + 32, 8 + 18)[0], 30);
}

TEST(ContactSheet, ReportsAnErrorWithoutPictures) {
  EXPECT_FALSE(ContactSheet().Compose());
}

TEST(Image, ShrinkTakesTheMean) {
  Image image(2, 2);
  image.Pixel(0, 0)[0] = 10;
  image.Pixel(1, 0)[0] = 20;
  image.Pixel(0, 1)[0] = 30;
  image.Pixel(1, 1)[0] = 40;
  EXPECT_EQ(Shrink(image, 2).Pixel(0, 0)[0], 25);
}

TEST(Image, PasteClipsAtTheBorder) {
  Image image(4, 4);
  Paste(Plain(99), 2, -34, image);
  EXPECT_EQ(image.Pixel(3, 1)[0], 99);
  EXPECT_EQ(image.Pixel(3, 2)[0], 0);
  EXPECT_EQ(image.Pixel(1, 0)[0], 0);
}

}  // namespace
}  // namespace visual_node
