#include "tools/transport/scatter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace transport {
namespace {

TEST(Scatter, OfTwelveValuesReachesFromTheThirdToTheTenth) {
  const Scatter scatter = ScatterOf({12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, std::numeric_limits<double>::quiet_NaN()});
  EXPECT_EQ(scatter.low, 3.0);  // 2 (1 + 12 + 66) / 4096 = 0.039 lies beyond; one place further in it would be 0.146
  EXPECT_EQ(scatter.high, 10.0);
  EXPECT_TRUE(scatter.excludes_zero());
}

TEST(Scatter, OfFiveValuesIsUnbounded) {
  const Scatter scatter = ScatterOf({1, 2, 3, 4, 5});
  EXPECT_EQ(scatter.median, 3.0);
  EXPECT_TRUE(std::isnan(scatter.low) && std::isnan(scatter.high));
  EXPECT_FALSE(scatter.excludes_zero());
  EXPECT_TRUE(std::isnan(ScatterOf({}).median));
}

TEST(Scatter, HoldsTheTrueMedianNineteenTimesOfTwenty) {
  std::mt19937_64 random(1);
  int num_held = 0;
  constexpr int kTrials = 2000;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<double> values;
    for (int i = 0; i < 12; ++i) values.push_back(static_cast<double>(random() >> 11) * 0x1p-53 - 0.5);
    num_held += ScatterOf(values).excludes_zero() ? 0 : 1;
  }
  EXPECT_GE(num_held, kTrials * 95 / 100);
}

TEST(Scatter, OfADifferenceIsFreeOfWhatBothShareInARound) {
  const std::vector<double> one = {11, 22, 13, 31, 17, 26, 19, 14}, other = {10, 21, 12, 30, 16, 25, 18, 13};
  EXPECT_EQ(DifferenceText(ScatterOfDifference(one, other), "us"), "1 us (1 to 1)");
  EXPECT_EQ(DifferenceText(ScatterOfDifference({1, 2, 1, 2, 1, 2}, {2, 1, 2, 1, 2, 1}), "us"),
            "none beyond the scatter (-1 to 1 us)");
}

}  // namespace
}  // namespace transport
