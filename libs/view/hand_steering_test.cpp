#include "view/hand_steering.hpp"

#include <gtest/gtest.h>

#include "core/pose.hpp"
#include "view/projection.hpp"

namespace view {
namespace {

constexpr int kWindowWidth = 800, kWindowHeight = 600;

scene::Camera Camera(const glm::dvec3& eye_m) {
  scene::Camera camera;
  camera.eye_m = eye_m;
  camera.target_m = {0, 0, 0};
  return camera;
}

TEST(HandSteering, TheHandStaysUnderTheCursorFromEveryView) {
  for (const glm::dvec3& eye_m : {glm::dvec3(0, -1, 0.5), glm::dvec3(2, 1, 1), glm::dvec3(0, 0, 3)}) {
    const scene::Camera camera = Camera(eye_m);
    HandSteering steering;
    const glm::dvec3 p_W(0.05, 0.02, -0.03);
    SteeringWish wish;
    wish.is_held = true;
    wish.drag_px = {120, 45};  // right, up
    const core::HandInput& input = steering.Update(wish, camera, kWindowHeight, p_W, 0.03);
    const glm::dvec3 before = ProjectToPixel(camera, kWindowWidth, kWindowHeight, p_W);
    const glm::dvec3 after = ProjectToPixel(camera, kWindowWidth, kWindowHeight, p_W + input.moved_W_m);
    EXPECT_NEAR(after.x - before.x, 120.0, 1e-6);
    EXPECT_NEAR(before.y - after.y, 45.0, 1e-6);
    EXPECT_NEAR(after.z, before.z, 1e-9) << "in the plane of the view";
  }
}

TEST(HandSteering, TheWheelMovesAwayFromTheEye) {
  HandSteering steering;
  SteeringWish wish;
  wish.is_held = true;
  wish.wheel = 2.0;
  const scene::Camera camera = Camera({0, -1, 0});
  EXPECT_NEAR(steering.Update(wish, camera, kWindowHeight, {0, 0, 0}, 0.03).moved_W_m.y, 0.02, 1e-12);
  wish.is_fine = true;
  EXPECT_NEAR(steering.Update(wish, camera, kWindowHeight, {0, 0, 0}, 0.03).moved_W_m.y, 0.024, 1e-12);
}

TEST(HandSteering, WithTheClutchOpenNothingMoves) {
  HandSteering steering;
  SteeringWish wish;
  wish.drag_px = {100, 100};
  wish.push = {1, 1, 1};
  wish.closing = 0.7;
  const core::HandInput& input = steering.Update(wish, Camera({0, -1, 0}), kWindowHeight, {0, 0, 0}, 0.03);
  EXPECT_FALSE(input.is_held);
  EXPECT_EQ(input.moved_W_m, glm::dvec3(0.0));
  EXPECT_EQ(input.turned_W_rad, glm::dvec3(0.0));
  EXPECT_EQ(input.closing, 0.7);
}

// The point of the hand that faces the eye goes to the right in the picture when it is turned by a drag to the right,
// and upwards by one upwards.
TEST(HandSteering, ATurnTakesWhatFacesTheEyeAlongWithTheCursor) {
  const scene::Camera camera = Camera({0, -1, 0});
  for (const glm::dvec2& drag_px : {glm::dvec2(60, 0), glm::dvec2(0, 60)}) {
    HandSteering steering;
    SteeringWish wish;
    wish.is_held = wish.turns = true;
    wish.drag_px = drag_px;
    const core::HandInput& input = steering.Update(wish, camera, kWindowHeight, {0, 0, 0}, 0.03);
    EXPECT_EQ(input.moved_W_m, glm::dvec3(0.0));
    const glm::dvec3 front = core::QuaternionFromRotationVector(input.turned_W_rad) * glm::dvec3(0, -0.05, 0);
    const glm::dvec3 at = ProjectToPixel(camera, kWindowWidth, kWindowHeight, front);
    EXPECT_GT((at.x - 0.5 * kWindowWidth) * drag_px.x + (0.5 * kWindowHeight - at.y) * drag_px.y, 0.0);
  }
}

TEST(HandSteering, KeysMoveAtAPaceThatDoesNotDependOnThePictures) {
  SteeringWish wish;
  wish.is_held = true;
  wish.push = {1, 0, 0};
  HandSteering slow, fast;
  const scene::Camera camera = Camera({0, -1, 0});
  for (int i = 0; i < 10; ++i) slow.Update(wish, camera, kWindowHeight, {0, 0, 0}, 0.1);
  for (int i = 0; i < 100; ++i) fast.Update(wish, camera, kWindowHeight, {0, 0, 0}, 0.01);
  EXPECT_NEAR(slow.input().moved_W_m.x, 0.15, 1e-9);
  EXPECT_NEAR(fast.input().moved_W_m.x, 0.15, 1e-9);
}

}  // namespace
}  // namespace view
