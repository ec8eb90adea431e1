#include "view/conformance/compare.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "view/conformance/cast_ids.hpp"

namespace view {
namespace {

Rendering FourPixels(std::uint16_t id, std::uint8_t grey) {
  Rendering rendering{{4, 4}, {4, 4}};
  for (std::size_t i = 0; i < 16; ++i) {
    rendering.ids.values[i] = id;
    for (std::size_t k = 0; k < 3; ++k) rendering.image.rgba[4 * i + k] = grey;
  }
  return rendering;
}

TEST(Compare, ARenderingAgreesWithItself) {
  const Agreement agreement = Compare(FourPixels(1, 90), FourPixels(1, 90));
  EXPECT_EQ(agreement.same_ids, 1.0);
  EXPECT_EQ(agreement.same_ids_inside, 1.0);
  EXPECT_EQ(agreement.flip, 0.0);
}

TEST(Compare, CountsPixelsOfAnotherObject) {
  Rendering other = FourPixels(1, 90);
  other.ids.values[0] = 2;  // a corner
  const Agreement agreement = Compare(FourPixels(1, 90), other);
  EXPECT_EQ(agreement.same_ids, 15.0 / 16.0);
  EXPECT_EQ(agreement.same_ids_inside, 1.0);
  other.ids.values[5] = 2;
  EXPECT_EQ(Compare(FourPixels(1, 90), other).same_ids_inside, 0.75);
}

TEST(Compare, LeavesTheSkyOut) {
  EXPECT_EQ(Compare(FourPixels(0, 0), FourPixels(0, 255)).flip, 0.0);
  EXPECT_GT(Compare(FourPixels(1, 0), FourPixels(1, 255)).flip, 0.9);
}

TEST(CastIds, ABallCoversItsAnalyticShareOfThePicture) {
  // Seen from the distance d along its axis, a ball of radius r is a disc of tan = r / sqrt(d^2 - r^2).
  scene::Camera camera;
  camera.eye_m = {0.0, -2.0, 0.0};
  camera.vertical_fov_rad = 0.5;
  const KnownBody ball{true, glm::dvec3(0.4), {}};
  const auto ids = CastIds({ball}, camera, 400, 400);
  double count = 0.0;
  for (const std::uint16_t id : ids.values) count += id;
  const double radius_px = 200.0 / std::tan(0.25) * 0.2 / std::sqrt(4.0 - 0.04);
  EXPECT_NEAR(count, std::acos(-1.0) * radius_px * radius_px, 0.002 * count);
}

TEST(CastIds, TheNearerBodyHidesTheOther) {
  scene::Camera camera;
  camera.eye_m = {0.0, -2.0, 0.0};
  KnownBody near{false, glm::dvec3(0.2), {}}, far{true, glm::dvec3(0.6), {}};
  near.X_WO.translation.y = -1.0;
  const auto ids = CastIds({far, near}, camera, 100, 100);
  EXPECT_EQ(*ids.Pixel(50, 50), 2);
  EXPECT_EQ(*ids.Pixel(0, 0), 0);
}

}  // namespace
}  // namespace view
