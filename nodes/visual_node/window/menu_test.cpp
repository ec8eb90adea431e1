#include "nodes/visual_node/window/menu.hpp"

#include <gtest/gtest.h>

#include "nodes/visual_node/testing/gl_test.hpp"

namespace visual_node {
namespace {

const std::vector<std::string> kNames = {"plate", "block"};

class MenuTest : public GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped()) return;
    auto menu = Menu::Create();
    ASSERT_TRUE(menu) << menu.error().detail;
    menu_ = std::move(*menu);
    target_ = std::make_unique<RenderTarget>(1280, 720);
  }
  // The mouse goes there, and presses and lets go of its button.
  void Click(const glm::dvec2& at_px) {
    for (const bool is_down : {false, true, false}) menu_->Draw({at_px, is_down}, kNames, *target_, &choices_);
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
  }

  std::unique_ptr<Menu> menu_;
  std::unique_ptr<RenderTarget> target_;
  view::Choices choices_;
};

TEST_F(MenuTest, AClickOnEachEntryTogglesItsOverlay) {
  view::OverlaySet toggled;
  for (int y = 170; y < 640; y += 8) {  // below the title
    const view::OverlaySet last = choices_.overlays;
    Click({32.0, y});
    const view::OverlaySet changed = last ^ choices_.overlays;
    EXPECT_LE(changed.count(), 1u) << y;
    toggled |= changed;
  }
  EXPECT_TRUE(toggled.all()) << toggled;
  EXPECT_TRUE(menu_->has_mouse());
}

TEST_F(MenuTest, TheMouseIsFreeBesideIt) {
  Click({900.0, 300.0});
  Click({900.0, 300.0});
  EXPECT_FALSE(menu_->has_mouse());
  EXPECT_EQ(choices_.overlays, view::DefaultOverlays());
}

TEST_F(MenuTest, ItIsReadable) {
  Click({900.0, 300.0});
  const Image image = target_->Read();
  int bright = 0;
  for (int y = 180; y < 610; ++y) {
    for (int x = 10; x < 440; ++x) bright += image.Pixel(x, y)[1] > 200 ? 1 : 0;
  }
  EXPECT_GT(bright, 1500) << "letters";
}

}  // namespace
}  // namespace visual_node
