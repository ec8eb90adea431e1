#include "vps/multibody/pair_schedule.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace vps {
namespace {

core::Pose At(double x, double turn = 0.0) {
  return {core::QuaternionFromRotationVector({0.0, 0.0, turn}), {x, 0.0, 0.0}};
}

// Three balls of 0.1 m at 0, 1 and 2; pairs 0-1, 0-2, 1-2.
PairSchedule ThreeBalls() {
  PairSchedule schedule;
  for (int i = 0; i < 3; ++i) schedule.AddObject(At(i), {0.0, 0.0, 0.0}, 0.1);
  schedule.AddPair(0, 1, 0.0);
  schedule.AddPair(0, 2, 0.0);
  schedule.AddPair(1, 2, 0.0);
  schedule.Finish();
  return schedule;
}

std::vector<std::uint32_t> Pairs(std::initializer_list<std::uint32_t> pairs) {
  return pairs;
}

TEST(PairSchedule, SelectsEveryPairUntilItsStateIsSet) {
  PairSchedule schedule = ThreeBalls();
  EXPECT_EQ(schedule.Collect(), Pairs({0, 1, 2}));
  schedule.Rest(0, 0.5);
  schedule.Stop(1);
  EXPECT_EQ(schedule.Collect(), Pairs({2}));
  schedule.Hold(2);
  EXPECT_EQ(schedule.Collect(), Pairs({2}));
  schedule.Wake(0);
  EXPECT_EQ(schedule.Collect(), Pairs({0, 2}));
}

TEST(PairSchedule, RestsWhileBothTravelLessThanTheFreeDistance) {
  for (const double share : {0.0, 0.1, 0.5, 1.0}) {  // of the travel, by object 0
    PairSchedule schedule = ThreeBalls();
    schedule.Collect();
    for (std::size_t i = 0; i < 3; ++i) schedule.Stop(i);
    schedule.Rest(0, 0.8);
    int step = 0;
    do {
      ++step;
      schedule.SetPose(0, At(0.001 * step * share));
      schedule.SetPose(1, At(1.0 - 0.001 * step * (1.0 - share)));
    } while (schedule.Collect().empty());
    EXPECT_NEAR(step, 800, 1) << share;
  }
}

TEST(PairSchedule, AJumpAndATurnWakeAtOnce) {
  PairSchedule schedule = ThreeBalls();
  schedule.Collect();
  schedule.Rest(0, 0.8);
  schedule.Rest(1, 1.8);
  schedule.Rest(2, 0.8);
  EXPECT_TRUE(schedule.Collect().empty());
  schedule.SetPose(0, At(0.9));
  EXPECT_EQ(schedule.Collect(), Pairs({0}));
  schedule.Rest(0, 0.15);
  schedule.SetPose(1, At(1.0, 2.0));  // its fastest point moves by 2 sin(1) 0.1 m
  EXPECT_EQ(schedule.Collect(), Pairs({0}));
}

TEST(PairSchedule, TheOdometersUseUpTheFreeDistance) {
  PairSchedule schedule = ThreeBalls();
  schedule.Collect();
  schedule.Rest(0, 0.8);
  schedule.SetPose(0, At(0.1));
  schedule.SetPose(1, At(1.2));
  schedule.SetPose(1, At(1.1));
  EXPECT_NEAR(schedule.FreeDistance_m(0), 0.4, 1e-9);
  EXPECT_NEAR(schedule.BallGap(0), 0.8, 1e-12);
}

TEST(PairSchedule, DetectsPairsAtRest) {
  PairSchedule schedule = ThreeBalls();
  schedule.Collect();
  schedule.SetPose(2, At(2.1));
  schedule.Collect();
  EXPECT_FALSE(schedule.HasMoved(0));
  EXPECT_TRUE(schedule.HasMoved(1));
  schedule.SetPose(2, At(2.1));
  schedule.Collect();
  EXPECT_FALSE(schedule.HasMoved(1));
}

}  // namespace
}  // namespace vps
