#include "view/stereo.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "view/projection.hpp"

namespace view {
namespace {

constexpr int kEyeWidth = 640, kEyeHeight = 360;

// Looks along +y at a point 1.5 m away.
scene::Camera BetweenTheEyes() {
  scene::Camera camera;
  camera.eye_m = {0.0, -1.5, 0.2};
  camera.target_m = {0.0, 0.0, 0.2};
  camera.vertical_fov_rad = 0.8;
  return camera;
}

double Focal_px(int height) {
  return 0.5 * height / std::tan(0.5 * BetweenTheEyes().vertical_fov_rad);
}

TEST(Room, TheViewpointSeesThroughTheScreenWhatTheCameraSees) {
  scene::Camera camera = BetweenTheEyes();
  camera.target_m = {0.7, 0.3, -0.2};
  Viewing viewing;
  const Frustum frustum = FrustaOf(viewing, camera, kEyeWidth, kEyeHeight).at(0);
  for (const glm::dvec3& p_W : {glm::dvec3(0.1, 0.2, 0.3), glm::dvec3(0.7, 0.3, -0.2), glm::dvec3(0.4, 0.0, 0.6)}) {
    const glm::dvec3 seen = ProjectToPixel(frustum, kEyeWidth, kEyeHeight, p_W);
    const glm::dvec3 expected = ProjectToPixel(camera, kEyeWidth, kEyeHeight, p_W);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(seen[k], expected[k], 1e-9) << k;
  }
}

TEST(Room, AheadIsWhereTheCameraLooksAndUpIsUpInItsPicture) {
  const core::Pose X_WR = RoomOf(BetweenTheEyes());
  EXPECT_NEAR(glm::distance(X_WR.rotate({0, 1, 0}), glm::dvec3(0, 1, 0)), 0.0, 1e-12);
  EXPECT_NEAR(glm::distance(X_WR.rotate({0, 0, 1}), glm::dvec3(0, 0, 1)), 0.0, 1e-12);
  EXPECT_NEAR(glm::distance(X_WR.translation, BetweenTheEyes().eye_m), 0.0, 1e-12);
}

// With the eyes e apart, the screen at the distance D and a point at the distance z, the lines of sight cross the
// screen e (z - D) / z apart, uncrossed for what is behind it. In pixels of a picture with focal length f [px at
// distance 1]: e f (1/D - 1/z).
TEST(Stereo, DisparityIsThatOfSimilarTriangles) {
  Viewing viewing;
  viewing.stereo = Stereo::kAnaglyph;  // both eyes at full size
  const auto frusta = FrustaOf(viewing, BetweenTheEyes(), kEyeWidth, kEyeHeight);
  ASSERT_EQ(frusta.size(), 2u);
  for (const double z_m : {0.5, 1.0, 1.5, 3.0, 40.0}) {
    const glm::dvec3 p_W = BetweenTheEyes().eye_m + glm::dvec3(0.1, z_m, -0.05);
    const double left_px = ProjectToPixel(frusta[0], kEyeWidth, kEyeHeight, p_W).x;
    const double right_px = ProjectToPixel(frusta[1], kEyeWidth, kEyeHeight, p_W).x;
    EXPECT_NEAR(right_px - left_px, kEyeDistance_m * Focal_px(kEyeHeight) * (1.0 / 1.5 - 1.0 / z_m), 1e-9) << z_m;
    EXPECT_NEAR(ProjectToPixel(frusta[0], kEyeWidth, kEyeHeight, p_W).y,
                ProjectToPixel(frusta[1], kEyeWidth, kEyeHeight, p_W).y, 1e-9);
  }
}

TEST(Stereo, AHeadThatIsTiltedHasEyesAtDifferentHeights) {
  Viewing viewing;
  viewing.stereo = Stereo::kAnaglyph;
  viewing.X_RH = {glm::angleAxis(0.5, glm::dvec3(0, 1, 0)), {0.02, -0.1, 0.03}};  // its right ear goes down
  const auto frusta = FrustaOf(viewing, BetweenTheEyes(), kEyeWidth, kEyeHeight);
  const glm::dvec3 between = 0.5 * (frusta[0].eye_W + frusta[1].eye_W);
  EXPECT_NEAR(glm::distance(between, BetweenTheEyes().eye_m + glm::dvec3(0.02, -0.1, 0.03)), 0.0, 1e-12);
  EXPECT_NEAR(glm::distance(frusta[0].eye_W, frusta[1].eye_W), kEyeDistance_m, 1e-12);
  EXPECT_NEAR((frusta[0].eye_W - frusta[1].eye_W).z, kEyeDistance_m * std::sin(0.5), 1e-12);
  // What is in the screen's plane is at one place for both eyes.
  const glm::dvec3 p_W = BetweenTheEyes().target_m + glm::dvec3(0.2, 0.0, 0.1);
  EXPECT_NEAR(glm::distance(glm::dvec2(ProjectToPixel(frusta[0], kEyeWidth, kEyeHeight, p_W)),
                            glm::dvec2(ProjectToPixel(frusta[1], kEyeWidth, kEyeHeight, p_W))),
              0.0, 1e-9);
}

// Row i of an eye's picture is seen in the window's row 2 i, or 2 i + 1 for the right eye: a direction is at the same
// height of the window as in a picture of all rows.
TEST(Stereo, InterlacedRowsAreWhereTheyAreSeen) {
  for (const int height : {360, 361}) {
    Viewing viewing;
    viewing.stereo = Stereo::kInterlaced;
    const auto rows = FrustaOf(viewing, BetweenTheEyes(), kEyeWidth, height);
    viewing.stereo = Stereo::kAnaglyph;
    const auto whole = FrustaOf(viewing, BetweenTheEyes(), kEyeWidth, height);
    const glm::ivec2 size = EyeSize(Stereo::kInterlaced, kEyeWidth, height);
    for (std::size_t eye = 0; eye < 2; ++eye) {
      for (const double z : {-0.3, 0.0, 0.25}) {
        const glm::dvec3 p_W = BetweenTheEyes().target_m + glm::dvec3(0.1, 0.4, z);
        const double row = ProjectToPixel(rows[eye], size.x, size.y, p_W).y - 0.5;  // of the pixel's middle
        const double seen = 2.0 * row + static_cast<double>(eye) + 0.5;
        EXPECT_NEAR(seen, ProjectToPixel(whole[eye], kEyeWidth, height, p_W).y, 1e-9);
      }
    }
  }
}

TEST(Stereo, NamesAreFoundAgain) {
  for (const StereoInfo& info : kStereoModes) EXPECT_EQ(FindStereo(NameOf(info.mode)), info.mode);
  EXPECT_EQ(FindStereo("none"), Stereo::kNone);
  EXPECT_FALSE(FindStereo("sideways"));
}

// White for both eyes is white, so what both see alike keeps its colour; red is the left eye's alone, almost.
TEST(Stereo, DuboisKeepsWhiteAndSeparatesRed) {
  for (std::size_t row = 0; row < 3; ++row) {
    float left = 0.0f, right = 0.0f;
    for (std::size_t k = 0; k < 3; ++k) {
      left += kDuboisLeft[row][k];
      right += kDuboisRight[row][k];
    }
    EXPECT_NEAR(left + right, 1.0f, 0.02f) << row;
    EXPECT_NEAR(row == 0 ? right : left, 0.0f, 0.15f) << row;
  }
}

}  // namespace
}  // namespace view
