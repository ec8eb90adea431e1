#include "nodes/visual_node/window/saved_views.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

namespace visual_node {
namespace {

using testing::HasSubstr;

class SavedViewsTest : public testing::Test {
 protected:
  void SetUp() override {
    setenv("VR_OOS_VIEWS", folder_.c_str(), 1);
    assets_.instance_names = {"plate", "palm"};
  }
  void TearDown() override {
    std::filesystem::remove_all(folder_);
    unsetenv("VR_OOS_VIEWS");
  }
  // The detail of the error that a file of this text gives.
  std::string Refused(const std::string& text) {
    std::filesystem::create_directories(folder_);
    std::ofstream(ViewsFile("touch")) << text;
    const auto views = ReadViews(ViewsFile("touch"), assets_);
    EXPECT_FALSE(views) << text;
    return views ? "" : views.error().detail;
  }

  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / ("saved_views_" + std::to_string(getpid()));
  view::Assets assets_;
};

TEST_F(SavedViewsTest, WhatIsWrittenIsReadAgain) {
  std::vector<scene::Camera> views(3);
  views[0] = {.name = "view_1", .eye_m = {0.5, -0.8, 0.25}, .target_m = {0.0, 0.1, 0.2}};
  views[1] = {.name = "view_2", .eye_m = {0.0, 0.0, 0.3}, .vertical_fov_rad = 0.5, .object = 1};
  views[2] = {.name = "view_3", .eye_m = {0.0, 0.0, 0.4}, .object = 0, .is_mounted = true};
  ASSERT_TRUE(WriteViews(ViewsFile("touch"), views, assets_));
  const auto read = ReadViews(ViewsFile("touch"), assets_);
  ASSERT_TRUE(read) << read.error().detail;
  ASSERT_EQ(read->size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ((*read)[i].name, views[i].name);
    EXPECT_NEAR(glm::distance((*read)[i].eye_m, views[i].eye_m), 0.0, 1e-4);
    EXPECT_NEAR(glm::distance((*read)[i].target_m, views[i].target_m), 0.0, 1e-4);
    EXPECT_NEAR((*read)[i].vertical_fov_rad, views[i].vertical_fov_rad, 1e-4);
    EXPECT_EQ((*read)[i].object, views[i].object);
    EXPECT_EQ((*read)[i].is_mounted, views[i].is_mounted);
  }
  EXPECT_TRUE(ReadViews(ViewsFile("peg_in_hole"), assets_)->empty()) << "each scenario has its own";
}

TEST_F(SavedViewsTest, WhatIsNoViewIsRefusedWithItsLine) {
  EXPECT_THAT(Refused("<views>\n<camera name='a' eye_m='0 0 1' target_m='0 0 0' follows='handle'/></views>"),
              HasSubstr("line 2: there is no object 'handle' any more"));
  EXPECT_THAT(Refused("<views>\n\n<camera name='a' eye_m='0 0 1'/></views>"), HasSubstr("line 3: this is no view"));
  EXPECT_THAT(Refused("<views><camera name='a' eye_m='0 0 1' target_m='0 0 1'/></views>"), HasSubstr("no view"));
  EXPECT_THAT(Refused("<views><light/></views>"), HasSubstr("no view"));
  EXPECT_THAT(Refused("<views><camera"), HasSubstr("touch.xml"));
}

}  // namespace
}  // namespace visual_node
