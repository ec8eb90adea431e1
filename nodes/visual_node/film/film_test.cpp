#include "nodes/visual_node/film/film.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
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

// By shaders, and by the processor.
class FilmTest : public GlTest, public testing::WithParamInterface<bool> {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    if (IsSkipped()) return;
    auto film = Film::Create(GetParam());
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

TEST_P(FilmTest, APictureIsExposureToneCurveAndSrgbWithinOneCode) {
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

TEST_P(FilmTest, AnEdgeOfABodyIsSmoothedAndAStarIsNot) {
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

TEST_P(FilmTest, TheLightMeterTakesTheGeometricMeanOfBodiesAlone) {
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

TEST_P(FilmTest, ASmallerFilmFillsTheTarget) {
  const RenderTarget target(64, 64);
  film_.Begin(24, 24);
  Fill(0, 0, 24, 24, glm::vec4(0.5f, 0.5f, 0.5f, 1.0f));
  film_.Develop(1.0f, target);
  const Image image = target.Read();
  const int code = Code(EncodeSrgb(ToneCurve(glm::vec3(0.5f))).g);
  for (const int at : {0, 31, 63}) EXPECT_NEAR(image.Pixel(at, at)[1], code, 1);
}

INSTANTIATE_TEST_SUITE_P(By, FilmTest, testing::Bool(),
                         [](const auto& given) { return given.param ? "Processor" : "Shaders"; });

class DarkroomTest : public GlTest {};

TEST_F(DarkroomTest, ThePictureIsTheShadersWithinTwoCodes) {
  // Slopes, curves and corners in many lights, stars between them; as large as the target, smaller, and of odd sizes.
  struct Case {
    int width, height, target_width, target_height;
  };
  constexpr float kLevels[5] = {0.02f, 0.4f, 0.5f, 0.7f,
                                1.8f};  // some edges are too weak to be smoothed, some hardly not
  for (const Case& c : {Case{96, 54, 96, 54}, Case{67, 37, 96, 54}, Case{33, 19, 130, 70}, Case{1, 1, 8, 8}}) {
    std::vector<float> light;
    for (int y = 0; y < c.height; ++y) {
      for (int x = 0; x < c.width; ++x) {
        const bool is_body = 3 * y < x + 20 || (x - 60) * (x - 60) + (y - 30) * (y - 30) < 150;
        const float level = is_body ? kLevels[(x / 7 + y / 5) % 5] : 0.001f;
        const bool is_star = !is_body && (x * 37 + y * 11) % 53 == 0;
        light.insert(light.end(),
                     {is_star ? 5.0f : level, is_star ? 4.0f : 0.8f * level, 0.4f * level, is_body ? 1.0f : 0.0f});
      }
    }
    std::vector<Image> images;
    for (const bool by_processor : {false, true}) {
      auto film = Film::Create(by_processor);
      ASSERT_TRUE(film) << film.error().detail;
      film->Begin(c.width, c.height);
      const GlTexture given = MakeTexture(GL_RGBA32F, c.width, c.height);
      glTextureSubImage2D(given.id(), 0, 0, 0, c.width, c.height, GL_RGBA, GL_FLOAT, light.data());
      GLuint from = 0;
      glCreateFramebuffers(1, &from);
      const GlFramebuffer owner(from);
      glNamedFramebufferTexture(from, GL_COLOR_ATTACHMENT0, given.id(), 0);
      glBlitNamedFramebuffer(from, film->framebuffer(), 0, 0, c.width, c.height, 0, 0, c.width, c.height,
                             GL_COLOR_BUFFER_BIT, GL_NEAREST);
      const RenderTarget target(c.target_width, c.target_height);
      film->Develop(1.3f, target);
      images.push_back(target.Read());
    }
    int largest = 0;
    for (std::size_t k = 0; k < images[0].rgba.size(); ++k) {
      largest = std::max(largest, std::abs(images[0].rgba[k] - images[1].rgba[k]));
    }
    EXPECT_LE(largest, 2) << c.width << " to " << c.target_width;
  }
}

}  // namespace
}  // namespace visual_node
