#include <gtest/gtest.h>

#include "tactile/testing/hostile_stimulation.hpp"

namespace tactile {
namespace {

TEST(LimiterSlow, NothingHostileGetsOverALimitIn1e7) {
  const HostileOutcome outcome = RunHostileStimulation(10'000'000, 2);
  EXPECT_EQ(outcome.first_wrong, "");
  EXPECT_GT(outcome.pulses, 500'000u);
  EXPECT_GT(outcome.stops, 5'000u);
}

}  // namespace
}  // namespace tactile
