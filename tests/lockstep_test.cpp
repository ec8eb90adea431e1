#include <gtest/gtest.h>

#include "tests/support.hpp"

namespace system_tests {
namespace {

const lockstep::StepOutcome* FirstMissed(const lockstep::Outcome& outcome) {
  for (const lockstep::StepOutcome& step : outcome.steps) {
    if (!step.is_completed) return &step;
  }
  return nullptr;
}

TEST(Lockstep, SameSeedIsBitForBitTheSameWithOneAndTwoWorkers) {
  const scene::Scenario scenario = Load("touch");
  lockstep::Options options;
  options.duration_s = 8.0;
  const lockstep::Outcome first = InLockstep(scenario, options);
  const lockstep::Outcome again = InLockstep(scenario, options);
  options.workers = 2;
  const lockstep::Outcome two_workers = InLockstep(scenario, options);
  EXPECT_GT(first.contact_cycles, 500u);
  EXPECT_EQ(first.hash, again.hash);
  EXPECT_EQ(first.hash, two_workers.hash);
  EXPECT_EQ(first.work.points_tested, two_workers.work.points_tested);
}

TEST(Lockstep, AnotherSeedIsAnotherRun) {
  const scene::Scenario scenario = Load("touch");
  lockstep::Options options;
  options.duration_s = 2.0;
  options.seed = 1;
  const std::uint64_t one = InLockstep(scenario, options).hash;
  options.seed = 2;
  EXPECT_NE(one, InLockstep(scenario, options).hash);
}

// The device's own delay of 4 ms leaves 5 / (0.5 + 5) ms = 900 N/m of the 2500 N/m by the linear rule.
TEST(Lockstep, ALateDeviceLowersTheStiffnessOfTheHandTheSameWayInEachRun) {
  scene::Scenario scenario = Load("touch");
  lockstep::Options options;
  options.duration_s = 6.0;
  const lockstep::Outcome in_time = InLockstep(scenario, options);
  EXPECT_GT(in_time.least_stiffness_share, 1.0);
  EXPECT_EQ(in_time.used_stiffness_share, 1.0);
  scenario.devices[0].command_delay_s = 4e-3;
  const lockstep::Outcome late = InLockstep(scenario, options);
  EXPECT_NEAR(late.least_stiffness_share, 0.3, 0.07);
  EXPECT_EQ(late.used_stiffness_share, late.least_stiffness_share);
  EXPECT_GE(late.least_energy_J, -1e-3);
  EXPECT_LT(late.share_made_passive, 0.01);
  EXPECT_EQ(late.hash, InLockstep(scenario, options).hash);
}

TEST(Lockstep, WithoutThePairTheBlockIsNotPushed) {
  scene::Scenario scenario = Load("touch");
  scenario.stall_limit_s = 10.0;
  scenario.pairs[PairOf(scenario, "ball", "block")].is_active = false;
  const lockstep::Outcome outcome = InLockstep(scenario);
  EXPECT_FALSE(outcome.is_completed);
  const lockstep::StepOutcome* missed = FirstMissed(outcome);
  ASSERT_NE(missed, nullptr);
  EXPECT_EQ(missed->name, "push_block");
  EXPECT_FALSE(missed->why.empty());
}

}  // namespace
}  // namespace system_tests
