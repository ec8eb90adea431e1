#include <gtest/gtest.h>

#include "nodes/physics_node/node_loop.hpp"

namespace physics_node {
namespace {

constexpr std::int64_t kMs = core::kTick_ns;

TEST(TickPlan, MakesOneTickPerCycleWhenCyclesAreOnTime) {
  TickPlan plan(0);
  for (int i = 1; i <= 1000; ++i) EXPECT_EQ(plan.Plan(i * kMs + (i % 3) * 100'000, true), 1);
  EXPECT_EQ(plan.timer_ticks(), 0u);
}

TEST(TickPlan, WithoutCyclesTheTimerKeepsSimulatedTimeAtRealTime) {
  TickPlan plan(0);
  int made = 0;
  std::int64_t now = 0;
  while (now < 1000 * kMs) {
    now = plan.deadline_ns();
    made += plan.Plan(now, false);
  }
  EXPECT_NEAR(made, 1000, 2);
}

TEST(TickPlan, CatchesUpALateCycleAndDoesNotRunAheadInABurst) {
  TickPlan plan(0);
  int made = plan.Plan(1 * kMs, true);
  made += plan.Plan(5 * kMs, true);  // haptic_node stalled for 4 ms
  EXPECT_EQ(made, 5);
  for (int i = 0; i < 10; ++i) made += plan.Plan(5 * kMs + i, true);  // ten cycles at once
  EXPECT_LE(made, 5 + TickPlan::kMaxAhead);
}

TEST(TickPlan, DropsTheTimeOfALongStall) {
  TickPlan plan(0);
  EXPECT_EQ(plan.Plan(10'000 * kMs, true), 1);
  EXPECT_EQ(plan.dropped_ticks(), 9999u);
  EXPECT_EQ(plan.Plan(10'001 * kMs, true), 1);
}

}  // namespace
}  // namespace physics_node
