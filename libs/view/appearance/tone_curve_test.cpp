#include "view/appearance/tone_curve.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace view {
namespace {

int Code(float encoded) {
  return static_cast<int>(std::lround(255.0f * encoded));
}

TEST(ToneCurve, LeavesTheColoursOfMaterialsAsTheyAre) {
  // Only the 4 % that a dielectric mirrors are taken off.
  const glm::vec3 gold(0.8f, 0.5f, 0.2f);
  EXPECT_LT(glm::distance(ToneCurve(gold), gold - 0.04f), 1e-6f);
}

TEST(ToneCurve, RisesToOneAndNeverBeyond) {
  float last = -1.0f;
  for (float light = 0.0f; light < 1000.0f; light = 1.1f * light + 0.001f) {
    const float mapped = ToneCurve(glm::vec3(light)).g;
    EXPECT_GT(mapped, last) << light;
    EXPECT_LT(mapped, 1.0f);
    last = mapped;
  }
  EXPECT_GT(last, 0.995f);
}

TEST(SrgbEncoding, IsTheStandardsCurve) {
  EXPECT_EQ(Code(EncodeSrgb(glm::vec3(0.18f)).r), 118);
  for (int code = 0; code < 256; ++code) {
    const double v = code / 255.0;
    const double linear = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
    EXPECT_EQ(Code(EncodeSrgb(glm::vec3(static_cast<float>(linear))).g), code);
  }
}

}  // namespace
}  // namespace view
