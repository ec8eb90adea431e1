#include "tiles/refinement.hpp"

#include <gtest/gtest.h>

namespace tiles {
namespace {

Canvas Filled(float light, std::uint16_t depth) {
  Canvas canvas;
  canvas.Resize(2, 1);
  canvas.light = {PackLight(glm::vec3(light)), PackLight(glm::vec3(light))};
  canvas.depth = {depth, 0};
  return canvas;
}

TEST(Refinement, CountsSamplesWhileNothingChangesAndBeginsAnewWhenItDoes) {
  Refinement refinement;
  for (std::uint32_t sample = 0; sample <= Refinement::kMost; ++sample) EXPECT_EQ(refinement.Next(7), sample);
  EXPECT_EQ(refinement.Next(7), std::nullopt) << "good enough";
  EXPECT_EQ(refinement.Next(8), 0u);
  EXPECT_EQ(refinement.Next(8), 1u);
  EXPECT_EQ(refinement.Next(7), 0u);
}

TEST(Refinement, ShowsTheMeanOfTheSamplesWithTheDepthsOfTheCentres) {
  Refinement refinement;
  Canvas canvas = Filled(9.0f, 100);
  EXPECT_TRUE(refinement.Take(7, 0, &canvas));
  for (std::uint32_t sample = 1; sample <= Refinement::kFirstShown; ++sample) {
    canvas = Filled(sample % 2 == 0 ? 1.0f : 3.0f, 90);
    EXPECT_EQ(refinement.Take(7, sample, &canvas), sample == Refinement::kFirstShown);
  }
  EXPECT_EQ(UnpackLight(canvas.light[0]), glm::vec3(2.0f));
  EXPECT_EQ(canvas.depth[0], 100);
  EXPECT_EQ(canvas.depth[1], 0);
  EXPECT_EQ(UnpackLight(canvas.light[1]), glm::vec3(0.0f)) << "nothing is there";
}

TEST(Refinement, ASampleOfAnEarlierPictureIsNotMixedIn) {
  Refinement refinement;
  Canvas canvas = Filled(1.0f, 100);
  refinement.Take(7, 0, &canvas);
  refinement.Take(8, 0, &canvas);
  for (std::uint32_t sample = 1; sample <= 20; ++sample) EXPECT_FALSE(refinement.Take(7, sample, &canvas));
}

}  // namespace
}  // namespace tiles
