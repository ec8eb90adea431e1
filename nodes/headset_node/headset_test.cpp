#include "nodes/headset_node/headset.hpp"

#include <gtest/gtest.h>

#include <cmath>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "nodes/headset_node/eye_frustum.hpp"
#include "nodes/visual_node/testing/gl_test.hpp"

namespace headset_node {
namespace {

XrView Ahead() {
  XrView eye{};
  eye.type = XR_TYPE_VIEW;
  eye.pose.orientation.w = 1.0f;
  eye.fov = {-0.8f, 0.6f, 0.7f, -0.9f};
  return eye;
}

TEST(EyeFrustum, LooksAheadInTheRoomWithUpAtTheTop) {
  XrView eye = Ahead();
  eye.pose.position = {0.03f, 1.5f, -0.2f};  // to the right, up, ahead
  const core::Pose X_WR{glm::angleAxis(0.4, glm::dvec3(0, 0, 1)), {1.0, 2.0, 3.0}};
  const view::Frustum frustum = FrustumOf(X_WR, eye);
  EXPECT_NEAR(glm::distance(frustum.eye_W, X_WR * glm::dvec3(0.03, 0.2, 1.5)), 0.0, 1e-7);
  EXPECT_NEAR(glm::distance(-frustum.R_WE[2], X_WR.rotate({0, 1, 0})), 0.0, 1e-12) << "ahead";
  EXPECT_NEAR(glm::distance(frustum.R_WE[1], X_WR.rotate({0, 0, 1})), 0.0, 1e-12) << "up";
  EXPECT_NEAR(frustum.left, std::tan(-0.8), 1e-6);
  EXPECT_NEAR(frustum.right, std::tan(0.6), 1e-6);
  EXPECT_NEAR(frustum.top, std::tan(0.7), 1e-6);
  EXPECT_NEAR(frustum.bottom, std::tan(-0.9), 1e-6);
}

TEST(EyeFrustum, TurnsWithTheHead) {
  XrView eye = Ahead();
  const float half = 0.25f;  // to the left by 0.5 rad, about OpenXR's y
  eye.pose.orientation = {0.0f, std::sin(half), 0.0f, std::cos(half)};
  const view::Frustum frustum = FrustumOf({}, eye);
  EXPECT_NEAR(glm::distance(-frustum.R_WE[2], glm::dvec3(-std::sin(0.5), std::cos(0.5), 0.0)), 0.0, 1e-6);
}

class HeadsetTest : public visual_node::GlTest {};

// With any runtime; without one it is skipped. Monado's simulated headset will do: README.md.
TEST_F(HeadsetTest, TakesPicturesForBothEyes) {
  if (IsSkipped()) return;
  const auto headset = Headset::Open(glfwGetCurrentContext());
  if (!headset && headset.error().code == core::ErrorCode::kNotFound) GTEST_SKIP() << headset.error().detail;
  ASSERT_TRUE(headset) << headset.error().detail;
  const glm::ivec2 size_px = (*headset)->size_px();
  EXPECT_GT(size_px.x, 100);
  const visual_node::RenderTarget picture(size_px.x, size_px.y);
  int num_shown = 0;
  for (int tries = 0; tries < 2000 && num_shown < 10 && !(*headset)->is_over(); ++tries) {
    const auto is_wanted = (*headset)->BeginFrame();
    ASSERT_TRUE(is_wanted) << is_wanted.error().detail;
    if (!*is_wanted) continue;
    const auto& eyes = (*headset)->eyes();
    const view::Frustum left = FrustumOf({}, eyes[0]), right = FrustumOf({}, eyes[1]);
    EXPECT_NEAR(glm::distance(left.eye_W, right.eye_W), 0.063, 0.012) << "of people";
    const glm::dvec3 to_right = glm::transpose(left.R_WE) * (right.eye_W - left.eye_W);
    EXPECT_GT(to_right.x, 0.05);
    for (std::size_t eye = 0; eye < kNumEyes; ++eye) {
      const float grey[4] = {0.5f, 0.5f, 0.5f, 1.0f};
      glClearNamedFramebufferfv(picture.framebuffer(), GL_COLOR, 0, grey);
      const auto shown = (*headset)->Show(eye, picture);
      ASSERT_TRUE(shown) << shown.error().detail;
    }
    const auto ended = (*headset)->EndFrame();
    ASSERT_TRUE(ended) << ended.error().detail;
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    ++num_shown;
  }
  EXPECT_EQ(num_shown, 10);
}

}  // namespace
}  // namespace headset_node
