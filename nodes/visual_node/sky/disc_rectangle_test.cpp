#include "nodes/visual_node/sky/disc_rectangle.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

namespace visual_node {
namespace {

constexpr int kViewWidth = 160, kViewHeight = 90;

// A ball's pixels by trying each: those whose ray passes its centre nearer than its radius.
glm::ivec4 ByTrying(const glm::mat4& clip_sky, const glm::vec3& to_centre, float sine) {
  const glm::dmat4 back = glm::inverse(glm::dmat4(clip_sky));
  glm::ivec2 low(kViewWidth, kViewHeight), high(-1);
  for (int y = 0; y < kViewHeight; ++y) {
    for (int x = 0; x < kViewWidth; ++x) {
      const glm::dvec4 far =
          back * glm::dvec4(2.0 * (x + 0.5) / kViewWidth - 1.0, 2.0 * (y + 0.5) / kViewHeight - 1.0, 1.0, 1.0);
      const glm::dvec3 d = glm::normalize(glm::dvec3(far) / far.w), e(to_centre);
      if (glm::dot(d, e) <= 0.0 || glm::length(glm::cross(d, e)) > sine) continue;
      low = glm::min(low, glm::ivec2(x, y));
      high = glm::max(high, glm::ivec2(x, y));
    }
  }
  return high.x < 0 ? glm::ivec4(0) : glm::ivec4(low, high - low + 1);
}

TEST(DiscRectangle, HasAllPixelsOfTheDiscAndFewOthers) {
  std::mt19937 random(4);
  const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1.0p-24f; };
  int num_seen = 0;
  for (int i = 0; i < 400; ++i) {
    const glm::vec3 view = glm::normalize(glm::vec3(uniform(), uniform(), uniform()) - 0.5f);
    const glm::mat4 clip_sky = glm::perspective(0.4f + uniform(), 16.0f / 9.0f, 0.01f, 60.0f) *
                               glm::lookAt(glm::vec3(0.0f), view, glm::vec3(0.0f, 0.0f, 1.0f));
    const glm::vec3 to_centre = glm::normalize(glm::vec3(uniform(), uniform(), uniform()) - 0.5f);
    const float sine = 0.05f + 0.9f * uniform();
    const glm::ivec4 pixels = ByTrying(clip_sky, to_centre, sine);
    const glm::ivec4 box = DiscRectangle(clip_sky, to_centre, sine, kViewWidth, kViewHeight);
    if (pixels.z == 0) continue;
    ++num_seen;
    EXPECT_LE(box.x, pixels.x) << i;
    EXPECT_LE(box.y, pixels.y) << i;
    EXPECT_GE(box.x + box.z, pixels.x + pixels.z) << i;
    EXPECT_GE(box.y + box.w, pixels.y + pixels.w) << i;
    // One pixel more on each side, as long as the whole disc is in the picture.
    const bool is_inside =
        pixels.x > 0 && pixels.y > 0 && pixels.x + pixels.z < kViewWidth && pixels.y + pixels.w < kViewHeight;
    if (is_inside) {
      EXPECT_LE(box.z, pixels.z + 3) << i;
      EXPECT_LE(box.w, pixels.w + 3) << i;
    }
  }
  EXPECT_GT(num_seen, 50);
}

TEST(DiscRectangle, IsEmptyForABallBehindTheEye) {
  const glm::mat4 clip_sky = glm::perspective(0.8f, 16.0f / 9.0f, 0.01f, 60.0f);
  EXPECT_EQ(DiscRectangle(clip_sky, {0.0f, 0.0f, 1.0f}, 0.3f, kViewWidth, kViewHeight).z, 0);
}

}  // namespace
}  // namespace visual_node
