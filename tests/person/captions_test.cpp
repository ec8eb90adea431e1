#include "tests/person/captions.hpp"

#include <gtest/gtest.h>

namespace person_tests {
namespace {

TEST(Captions, AreReadAsTheyWereWritten) {
  const auto atlas = picture::GlyphAtlas::Create(20);
  const auto reader = CaptionReader::Create();
  ASSERT_TRUE(atlas && reader);
  const std::vector<std::string> written = {"hand right: held, jaws open   [|||||...................] 12 N",
                                            "next: left 120, down 4.7, away 31 mm; Ctrl: right 8.6, near 5.0 deg",
                                            "next: close the jaws"};
  picture::Image image(1280, 200);
  for (std::size_t i = 0; i < image.rgba.size(); ++i) image.rgba[i] = static_cast<std::uint8_t>(20 + i % 60);
  int y = 17;
  for (const std::string& line : written) {
    atlas->Draw(line, 20, y, {255, 224, 122}, image);
    y += atlas->line_height();
  }
  GreyPicture grey{image.width, image.height, {}};
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    grey.values.push_back(static_cast<unsigned char>((image.rgba[i] + image.rgba[i + 1] + image.rgba[i + 2]) / 3));
  }
  EXPECT_EQ(reader->Read(grey), written);
}

}  // namespace
}  // namespace person_tests
