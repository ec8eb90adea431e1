#include "view/frustum.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "view/projection.hpp"

namespace view {
namespace {

constexpr int kScreenWidth = 640, kScreenHeight = 360;

scene::Camera Oblique() {
  scene::Camera camera;
  camera.eye_m = {0.4, -1.3, 0.9};
  camera.target_m = {0.1, 0.2, 0.3};
  camera.vertical_fov_rad = 0.7;
  return camera;
}

// Where the line from the eye to a point crosses the screen's plane, as shares of its edges: exact, without any matrix.
glm::dvec2 OnScreen(const Screen& screen, const glm::dvec3& eye, const glm::dvec3& p) {
  const glm::dvec3 across = screen.lower_right - screen.lower_left, up = screen.upper_left - screen.lower_left;
  const glm::dvec3 normal = glm::cross(across, up);
  const double t = glm::dot(screen.lower_left - eye, normal) / glm::dot(p - eye, normal);
  const glm::dvec3 at = eye + t * (p - eye) - screen.lower_left;
  return {glm::dot(at, across) / glm::dot(across, across), glm::dot(at, up) / glm::dot(up, up)};
}

TEST(Frustum, OfACameraIsTheCamerasPinhole) {
  const Frustum frustum = FrustumOf(Oblique(), static_cast<double>(kScreenWidth) / kScreenHeight);
  for (const glm::dvec3& p_W : {glm::dvec3(0.1, 0.2, 0.3), glm::dvec3(-0.2, 0.5, 0.1), glm::dvec3(0.4, 0.0, 0.6)}) {
    const glm::dvec3 by_camera = ProjectToPixel(Oblique(), kScreenWidth, kScreenHeight, p_W);
    const glm::dvec3 by_frustum = ProjectToPixel(frustum, kScreenWidth, kScreenHeight, p_W);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(by_frustum[k], by_camera[k], 1e-9) << k;
  }
  EXPECT_NEAR(frustum.focus_m, glm::distance(Oblique().eye_m, Oblique().target_m), 1e-12);
}

// The corners of a picture are the corners of its screen, whatever the eye's place before it.
TEST(Frustum, PictureCornersAreOnTheScreensCorners) {
  std::mt19937 random(3);
  const auto uniform = [&](double a, double b) { return a + (b - a) * static_cast<double>(random() >> 8) * 0x1.0p-24; };
  double largest_px = 0.0;
  for (int i = 0; i < 200; ++i) {
    const glm::dvec3 x = glm::normalize(glm::dvec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)));
    const glm::dvec3 z = glm::normalize(glm::cross(x, glm::dvec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1))));
    const glm::dvec3 y = glm::cross(z, x), corner(uniform(-2, 2), uniform(-2, 2), uniform(-2, 2));
    const double width = uniform(0.3, 4.0), height = uniform(0.3, 3.0);
    const Screen screen{corner, corner + width * x, corner + height * y};
    const glm::dvec3 eye = corner + uniform(-1, 2) * width * x + uniform(-1, 2) * height * y + uniform(0.1, 3) * z;
    const Frustum frustum = FrustumThrough(screen, eye);
    const glm::dvec3 upper_right = screen.lower_right + height * y;
    const auto off = [&](const glm::dvec3& p, double px, double py) {
      return glm::length(glm::dvec2(ProjectToPixel(frustum, kScreenWidth, kScreenHeight, p)) - glm::dvec2(px, py));
    };
    largest_px = std::max({largest_px, off(screen.lower_left, 0, kScreenHeight),
                           off(screen.lower_right, kScreenWidth, kScreenHeight), off(screen.upper_left, 0, 0),
                           off(upper_right, kScreenWidth, 0)});
    // A point behind the screen, or before it, is where the line of sight crosses the screen.
    const glm::dvec3 p =
        eye + uniform(0.2, 9.0) * (corner + uniform(0, 1) * width * x + uniform(0, 1) * height * y - eye);
    const glm::dvec2 share = OnScreen(screen, eye, p);
    largest_px = std::max(largest_px, off(p, kScreenWidth * share.x, kScreenHeight * (1.0 - share.y)));
  }
  RecordProperty("largest_px", std::to_string(largest_px));
  EXPECT_LT(largest_px, 1e-6);
}

TEST(Frustum, MatricesAgreeWithProjectToPixel) {
  const Screen screen{{-1.0, 2.0, -0.5}, {1.5, 2.5, -0.5}, {-1.0, 2.0, 1.0}};
  const Frustum frustum = FrustumThrough(screen, {0.3, -0.2, 0.1});
  const glm::dmat4 clip_W = ProjectionMatrix(frustum, 0.01, 60.0) * ViewMatrix(frustum);
  for (const glm::dvec3& p_W : {glm::dvec3(0.2, 4.0, 0.3), glm::dvec3(-0.1, 1.0, 0.2), screen.upper_left}) {
    const glm::dvec4 clip = clip_W * glm::dvec4(p_W, 1.0);
    const glm::dvec3 pixel = ProjectToPixel(frustum, kScreenWidth, kScreenHeight, p_W);
    EXPECT_NEAR(0.5 * kScreenWidth * (1.0 + clip.x / clip.w), pixel.x, 1e-9);
    EXPECT_NEAR(0.5 * kScreenHeight * (1.0 - clip.y / clip.w), pixel.y, 1e-9);
    EXPECT_NEAR(clip.w, pixel.z, 1e-12);
  }
}

TEST(Frustum, AnEyeInTheScreensPlaneSeesAsFromACentimetre) {
  const Screen screen;
  for (const double y_m : {-0.01, 0.0, 0.5}) {
    const Frustum frustum = FrustumThrough(screen, {0.0, y_m, 0.0});
    EXPECT_NEAR(frustum.right, 100.0, 1e-9) << y_m;
    EXPECT_NEAR(frustum.left, -100.0, 1e-9) << y_m;
  }
}

TEST(Frustum, AScreenIsARectangle) {
  EXPECT_TRUE(CheckScreen({{-1, 2, -0.5}, {1.5, 2.5, -0.5}, {-1, 2, 1}}));
  EXPECT_FALSE(CheckScreen({{-1, 2, -0.5}, {-1, 2, -0.5}, {-1, 2, 1}})) << "no width";
  EXPECT_FALSE(CheckScreen({{-1, 2, -0.5}, {1, 2, 0.5}, {-1, 2, 1}})) << "oblique";
}

TEST(Frustum, FocalLengthsAndAxisDescribeTheSamePicture) {
  const Frustum frustum = FrustumThrough({{-1, 2, -0.5}, {1.5, 2, -0.5}, {-1, 2, 1}}, {0.3, -0.2, 0.1});
  const glm::dvec2 focal = FocalLengths_px(frustum, kScreenWidth, kScreenHeight),
                   axis = AxisFromMiddle_px(frustum, kScreenWidth, kScreenHeight);
  const glm::dvec3 d_E(0.2, -0.1, -1.0);
  const glm::dvec3 pixel = ProjectToPixel(frustum, kScreenWidth, kScreenHeight, frustum.eye_W + frustum.R_WE * d_E);
  EXPECT_NEAR(pixel.x, 0.5 * kScreenWidth + axis.x + focal.x * d_E.x, 1e-9);
  EXPECT_NEAR(pixel.y, 0.5 * kScreenHeight - axis.y - focal.y * d_E.y, 1e-9);
}

}  // namespace
}  // namespace view
