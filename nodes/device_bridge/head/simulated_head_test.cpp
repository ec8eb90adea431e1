#include "nodes/device_bridge/head/simulated_head.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/clock.hpp"

namespace device_bridge {
namespace {

TEST(SimulatedHead, MovesTheSameForTheSameSeedHoweverOftenItIsRead) {
  SimulatedHead often(7), seldom(7), other(8);
  double apart_m = 0.0;
  for (std::int64_t ms = 0; ms <= 4000; ++ms) {
    const core::Pose X_RH = *often.Read(ms * core::kTick_ns);
    if (ms % 8 != 0) continue;
    const core::Pose same = *seldom.Read(ms * core::kTick_ns);
    EXPECT_EQ(X_RH.translation, same.translation) << ms;
    EXPECT_EQ(X_RH.rotation, same.rotation) << ms;
    apart_m = std::max(apart_m, glm::distance(X_RH.translation, other.Read(ms * core::kTick_ns)->translation));
  }
  EXPECT_GT(apart_m, 0.01);
}

// A head on a trunk: within reach of a seat, and without jumps.
TEST(SimulatedHead, StaysNearTheViewpointAndDoesNotJump) {
  SimulatedHead head(3);
  glm::dvec3 low(1.0), high(-1.0), last = head.Read(0)->translation;
  for (std::int64_t ms = 1; ms <= 60'000; ++ms) {
    const core::Pose X_RH = *head.Read(ms * core::kTick_ns);
    EXPECT_LT(glm::distance(X_RH.translation, last), 1.0 * core::kTick_s) << "faster than 1 m/s at " << ms;
    last = X_RH.translation;
    low = glm::min(low, last);
    high = glm::max(high, last);
  }
  for (int k = 0; k < 3; ++k) {
    EXPECT_GT(low[k], -0.2);
    EXPECT_LT(high[k], 0.2);
  }
  EXPECT_GT(high.x - low.x, 0.05) << "it leans to both sides";
}

TEST(SimulatedHead, SaysThatItIsSimulated) {
  EXPECT_TRUE(SimulatedHead(1).is_simulated());
  EXPECT_NE(std::string(SimulatedHead(1).description()).find("SIMULATED"), std::string::npos);
}

}  // namespace
}  // namespace device_bridge
