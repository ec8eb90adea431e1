#include "view/layout.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace view {
namespace {

Assets ThreeCameras() {
  Assets assets;
  for (const char* name : {"overview", "gripper", "operator"}) {
    assets.cameras.emplace_back();
    assets.cameras.back().name = name;
  }
  return assets;
}

TEST(Layout, IsRowsOfCameras) {
  const auto layout = ReadLayout("* | gripper / operator", ThreeCameras());
  ASSERT_TRUE(layout) << layout.error().detail;
  EXPECT_EQ(layout->rows, (std::vector<std::vector<std::string>>{{"", "gripper"}, {"operator"}}));
  EXPECT_TRUE(layout->is_divided());
  EXPECT_EQ(layout->steered(), "");
  EXPECT_FALSE(Layout{}.is_divided());
}

TEST(Layout, MistakesAreNamed) {
  const auto unknown = ReadLayout("overview | griper", ThreeCameras());
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().detail, testing::HasSubstr("no camera 'griper'; it has overview, gripper, operator"));
  for (const char* text : {"", "overview |", "/ gripper", "overview / | gripper"}) {
    const auto empty = ReadLayout(text, ThreeCameras());
    ASSERT_FALSE(empty) << text;
    EXPECT_THAT(empty.error().detail, testing::HasSubstr("a view without a name"));
  }
}

// Each pixel belongs to one view at most; views of a row are as high, and all reach the window's edges but for two
// pixels.
TEST(Layout, PanesFillTheWindowWithoutOverlap) {
  const auto layout = ReadLayout("overview | gripper | operator / * / gripper | overview", ThreeCameras());
  ASSERT_TRUE(layout);
  for (const glm::ivec2 size : {glm::ivec2(640, 360), glm::ivec2(1279, 723)}) {
    std::vector<int> times(static_cast<std::size_t>(size.x * size.y), 0);
    for (const Pane& pane : PanesOf(*layout, size.x, size.y)) {
      for (int k = 0; k < 2; ++k) EXPECT_EQ(pane.corner_px[k] % 2, 0);
      for (int y = pane.corner_px.y; y < pane.corner_px.y + pane.size_px.y; ++y) {
        for (int x = pane.corner_px.x; x < pane.corner_px.x + pane.size_px.x; ++x) {
          ASSERT_LT(x, size.x);
          ASSERT_LT(y, size.y);
          ++times[static_cast<std::size_t>(y * size.x + x)];
        }
      }
    }
    EXPECT_LE(*std::max_element(times.begin(), times.end()), 1);
    EXPECT_LE(std::count(times.begin(), times.end(), 0), 3 * 2 * size.y + 3 * size.x * 2);
  }
  const std::vector<Pane> one = PanesOf({}, 641, 361);
  ASSERT_EQ(one.size(), 1u);
  EXPECT_EQ(one[0].size_px, glm::ivec2(641, 361));
}

}  // namespace
}  // namespace view
