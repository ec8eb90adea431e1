#include <gtest/gtest.h>

#include "tests/support.hpp"

namespace system_tests {
namespace {

const oos::StepOutcome* FirstMissed(const oos::LockstepOutcome& outcome) {
  for (const oos::StepOutcome& step : outcome.steps) {
    if (!step.is_completed) return &step;
  }
  return nullptr;
}

TEST(Lockstep, TouchCompletesFasterThanRealTimeUnderTheCap) {
  const scene::Scenario scenario = Load("touch");
  const oos::LockstepOutcome outcome = InLockstep(scenario);
  EXPECT_TRUE(outcome.is_completed) << outcome.why;
  EXPECT_GT(outcome.peak_force_N, 5.0);  // something was felt
  EXPECT_LT(outcome.peak_force_N, scenario.force_cap_N);
  EXPECT_LT(outcome.impulse_balance, 1e-9);
  EXPECT_GT(outcome.contact_cycles, 1000u);
#ifdef NDEBUG
  EXPECT_LT(outcome.wall_s, outcome.simulated_s);
#endif
}

TEST(Lockstep, SameSeedIsBitForBitTheSameWithOneAndTwoWorkers) {
  const scene::Scenario scenario = Load("touch");
  oos::LockstepOptions options;
  options.duration_s = 8.0;
  const oos::LockstepOutcome first = InLockstep(scenario, options);
  const oos::LockstepOutcome again = InLockstep(scenario, options);
  options.workers = 2;
  const oos::LockstepOutcome two_workers = InLockstep(scenario, options);
  EXPECT_GT(first.contact_cycles, 500u);
  EXPECT_EQ(first.hash, again.hash);
  EXPECT_EQ(first.hash, two_workers.hash);
  EXPECT_EQ(first.work.points_tested, two_workers.work.points_tested);
}

TEST(Lockstep, AnotherSeedIsAnotherRun) {
  const scene::Scenario scenario = Load("touch");
  oos::LockstepOptions options;
  options.duration_s = 2.0;
  options.seed = 1;
  const std::uint64_t one = InLockstep(scenario, options).hash;
  options.seed = 2;
  EXPECT_NE(one, InLockstep(scenario, options).hash);
}

TEST(Lockstep, WithoutThePairTheBlockIsNotPushed) {
  scene::Scenario scenario = Load("touch");
  scenario.stall_limit_s = 10.0;
  scenario.pairs[PairOf(scenario, "ball", "block")].is_active = false;
  const oos::LockstepOutcome outcome = InLockstep(scenario);
  EXPECT_FALSE(outcome.is_completed);
  const oos::StepOutcome* missed = FirstMissed(outcome);
  ASSERT_NE(missed, nullptr);
  EXPECT_EQ(missed->name, "push_block");
  EXPECT_FALSE(missed->why.empty());
}

TEST(Lockstep, WithoutContactsAtPhysicsNothingMoves) {
  scene::Scenario scenario = Load("touch");
  scenario.stall_limit_s = 10.0;
  oos::LockstepOptions options;
  options.loses_physics_wrench = true;
  const oos::LockstepOutcome outcome = InLockstep(scenario, options);
  EXPECT_FALSE(outcome.is_completed);
  ASSERT_NE(FirstMissed(outcome), nullptr);
}

TEST(Lockstep, ThePapersWrenchMovesTheBlockToo) {
  scene::Scenario scenario = Load("touch");
  scenario.contact_input = scene::ContactInput::kWrench;
  const oos::LockstepOutcome outcome = InLockstep(scenario);
  EXPECT_TRUE(outcome.is_completed) << outcome.why;
}

TEST(Lockstep, PegInHoleCompletes) {
  const scene::Scenario scenario = Load("peg_in_hole");
  const oos::LockstepOutcome outcome = InLockstep(scenario);
  EXPECT_TRUE(outcome.is_completed) << outcome.why;
  EXPECT_LT(outcome.peak_force_N, scenario.force_cap_N);
}

TEST(Lockstep, ModuleReplacementCompletes) {
  const scene::Scenario scenario = Load("module_replacement");
  const oos::LockstepOutcome outcome = InLockstep(scenario);
  EXPECT_TRUE(outcome.is_completed) << outcome.why;
  EXPECT_EQ(outcome.steps.size(), 7u);
  EXPECT_LT(outcome.peak_force_N, scenario.force_cap_N);
}

TEST(Lockstep, AStuckSwitchFailsInItsStep) {
  scene::Scenario scenario = Load("module_replacement");
  for (scene::Mechanism& mechanism : scenario.mechanisms) {
    if (mechanism.name == "switch_a") mechanism.is_stuck = true;
  }
  const oos::LockstepOutcome outcome = InLockstep(scenario);
  EXPECT_FALSE(outcome.is_completed);
  const oos::StepOutcome* missed = FirstMissed(outcome);
  ASSERT_NE(missed, nullptr);
  EXPECT_EQ(missed->name, "switch_off");
}

}  // namespace
}  // namespace system_tests
