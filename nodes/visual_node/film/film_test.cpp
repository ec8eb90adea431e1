#include "nodes/visual_node/film/film.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "nodes/visual_node/testing/gl_test.hpp"
#include "view/appearance/tone_curve.hpp"

namespace visual_node {
namespace {

using view::EncodeSrgb;
using view::ToneCurve;

int Code(float encoded) {
  return static_cast<int>(std::lround(255.0f * encoded));
}

class FilmTest : public GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped()) return;
    auto film = Film::Create();
    ASSERT_TRUE(film) << film.error().detail;
    film_ = std::move(*film);
  }
  void Fill(int x, int y, int width, int height, const glm::vec4& light) const {
    glEnable(GL_SCISSOR_TEST);
    glScissor(x, y, width, height);
    glClearBufferfv(GL_COLOR, 0, &light.x);
    glDisable(GL_SCISSOR_TEST);
  }
  Film film_;
};

TEST_F(FilmTest, TheShadersPictureIsExposureToneCurveAndSrgbWithinOneCode) {
  const float levels[8] = {0.0f, 0.004f, 0.02f, 0.09f, 0.3f, 0.7f, 2.0f, 30.0f};
  const RenderTarget target(64, 64);
  film_.Begin(64, 64);
  const auto light = [&](int i) { return glm::vec4(levels[i % 8], levels[i / 8], levels[(i * 5 + 3) % 8], 0.0f); };
  for (int i = 0; i < 64; ++i) Fill(8 * (i % 8), 8 * (i / 8), 8, 8, light(i));
  film_.Develop(1.5f, target);
  const Image image = target.Read();
  for (int i = 0; i < 64; ++i) {
    const glm::vec3 wanted = EncodeSrgb(glm::clamp(ToneCurve(1.5f * glm::vec3(light(i))), 0.0f, 1.0f));
    const std::uint8_t* pixel = image.Pixel(8 * (i % 8) + 4, 63 - (8 * (i / 8) + 4));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(pixel[c], Code(wanted[c]), 1) << i << " " << c;
  }
}

TEST_F(FilmTest, AnEdgeOfABodyIsSmoothedAndAStarIsNot) {
  const RenderTarget target(64, 64);
  film_.Begin(64, 64);
  Fill(0, 0, 64, 64, glm::vec4(0.0f));
  for (int x = 0; x < 64; ++x) Fill(x, 0, 1, 8 + x / 4, glm::vec4(0.7f, 0.7f, 0.7f, 1.0f));  // a flat slope in steps
  Fill(20, 50, 1, 1, glm::vec4(0.7f, 0.7f, 0.7f, 0.0f));
  film_.Develop(1.0f, target);
  const Image image = target.Read();
  int between = 0;
  for (int y = 32; y < 64; ++y) {
    for (int x = 8; x < 56; ++x) between += image.Pixel(x, y)[1] > 40 && image.Pixel(x, y)[1] < 180;
  }
  EXPECT_GT(between, 24);
  EXPECT_EQ(image.Pixel(20, 63 - 50)[1], Code(EncodeSrgb(ToneCurve(glm::vec3(0.7f))).g));
  EXPECT_EQ(image.Pixel(21, 63 - 50)[1], 0);
  EXPECT_EQ(image.Pixel(20, 63 - 51)[1], 0);
}

TEST_F(FilmTest, TheLightMeterTakesTheGeometricMeanOfBodiesAlone) {
  film_.Begin(64, 36);
  Fill(0, 0, 64, 36, glm::vec4(9.0f, 9.0f, 9.0f, 0.0f));
  EXPECT_FALSE(film_.MeanLuminance());
  film_.Begin(64, 36);
  Fill(0, 0, 16, 36, glm::vec4(0.2f, 0.2f, 0.2f, 1.0f));
  Fill(16, 0, 16, 36, glm::vec4(0.8f, 0.8f, 0.8f, 1.0f));
  const auto mean = film_.MeanLuminance();
  ASSERT_TRUE(mean);
  EXPECT_NEAR(*mean, 0.4f, 0.002f);
}

TEST_F(FilmTest, ASmallerFilmFillsTheTarget) {
  const RenderTarget target(64, 64);
  film_.Begin(24, 24);
  Fill(0, 0, 24, 24, glm::vec4(0.5f, 0.5f, 0.5f, 1.0f));
  film_.Develop(1.0f, target);
  const Image image = target.Read();
  const int code = Code(EncodeSrgb(ToneCurve(glm::vec3(0.5f))).g);
  for (const int at : {0, 31, 63}) EXPECT_NEAR(image.Pixel(at, at)[1], code, 1);
}

}  // namespace
}  // namespace visual_node
