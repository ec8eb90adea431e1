#include "tools/oos/device/wiggle.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace oos {
namespace {

// Device 1 is moved to and fro by 4 cm; device 0 lies on the table, with a sensor's noise of 2 mm.
TEST(Wiggle, FindsTheDeviceThatIsMovedToAndFroAmongNoisyOnes) {
  Wiggle wiggle(2);
  double way_m = 0.0;
  for (int i = 0; i < 2000 && !wiggle.winner(); ++i) {
    const double x_m = 0.02 * std::sin(0.01 * i);
    wiggle.Add(0, {i % 2 == 0 ? 0.001 : -0.001, 0, 0});
    wiggle.Add(1, {x_m, 0, 0});
    way_m = 0.02 * 4.0 * i * 0.01 / 6.283185307179586;
  }
  ASSERT_TRUE(wiggle.winner());
  EXPECT_EQ(*wiggle.winner(), 1U);
  EXPECT_NEAR(way_m, 0.15, 0.03);
}

TEST(Wiggle, DoesNotDecideWhileTwoAreMoved) {
  Wiggle wiggle(2);
  for (int i = 0; i < 2000; ++i) {
    const double x_m = 0.02 * std::sin(0.01 * i);
    wiggle.Add(0, {0.5 * x_m, 0, 0});
    wiggle.Add(1, {x_m, 0, 0});
    EXPECT_FALSE(wiggle.winner());
  }
  EXPECT_FALSE(Wiggle(0).winner());
}

}  // namespace
}  // namespace oos
