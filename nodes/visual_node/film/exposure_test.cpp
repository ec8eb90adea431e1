#include "nodes/visual_node/film/exposure.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace visual_node {
namespace {

TEST(Exposure, BringsTheMeanOfAPictureToGrey) {
  Exposure exposure;
  for (int i = 0; i < 300; ++i) exposure.Update(0.1f, 1.0 / 30.0);
  EXPECT_NEAR(exposure.value() * 0.1f, Exposure::kGrey, 1e-3);
}

TEST(Exposure, AfterOneTimeConstantIsNearerByOneMinusOneOverE) {
  Exposure exposure;
  exposure.Update(0.1f, Exposure::kTimeConstant_s);
  const double wanted = Exposure::kGrey / 0.1;
  EXPECT_NEAR(std::log(exposure.value() / wanted), std::exp(-1.0) * std::log(Exposure::kDaylight / wanted), 1e-4);
}

TEST(Exposure, DependsOnTheTimeAndNotOnHowManyPicturesItHad) {
  Exposure few, many;
  for (int i = 0; i < 3; ++i) few.Update(0.07f, 0.1);
  for (int i = 0; i < 30; ++i) many.Update(0.07f, 0.01);
  EXPECT_NEAR(few.value(), many.value(), 1e-4);
}

TEST(Exposure, StaysWithinItsLimitsAndIgnoresEmptySpace) {
  Exposure dark, bright, empty;
  for (int i = 0; i < 1000; ++i) {
    dark.Update(0.0f, 0.1);
    bright.Update(1e4f, 0.1);
    empty.Update(std::nullopt, 0.1);
  }
  EXPECT_NEAR(dark.value(), Exposure::kMost, 1e-4);
  EXPECT_NEAR(bright.value(), Exposure::kLeast, 1e-4);
  EXPECT_EQ(empty.value(), Exposure::kDaylight);
}

}  // namespace
}  // namespace visual_node
