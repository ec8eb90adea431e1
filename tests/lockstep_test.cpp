#include <gtest/gtest.h>

#include "bus/log/mcap_reader.hpp"
#include "nodes/haptic_node/step.hpp"
#include "nodes/lockstep/replay_steps.hpp"
#include "replay/step_codec.hpp"
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

// `touch` until the hand pushes the free block.
std::filesystem::path RecordTouch() {
  const auto file = std::filesystem::path(::testing::TempDir()) / "both_kinds_of_step.mcap";
  std::filesystem::remove(file);  // of a run that was killed
  lockstep::Options options;
  options.steps = file;
  InLockstep(Load("touch"), options);
  return file;
}

lockstep::StepsOutcome ReplayHaptic(const std::filesystem::path& file, const scene::Scenario& scenario) {
  const auto nodes = lockstep::ReadRecordedNodes(file);
  EXPECT_TRUE(nodes);
  for (const lockstep::RecordedNode& node : *nodes) {
    if (node.node != "haptic_node") continue;
    const auto outcome = lockstep::ReplaySteps(file, node, scenario, {});
    EXPECT_TRUE(outcome) << outcome.error().detail;
    return outcome.value_or(lockstep::StepsOutcome{});
  }
  ADD_FAILURE() << "haptic_node is not recorded";
  return {};
}

TEST(Lockstep, ReplayRepeatsCyclesAndReevaluationsBitForBit) {
  const std::filesystem::path file = RecordTouch();
  std::uint64_t num_cycles = 0, num_reevaluations = 0;
  const auto read = bus::log::ReadMcap(file, [&](const bus::log::Channel& channel, const bus::log::Message& message) {
    if (channel.topic != "replay/haptic_node/step") return;
    ++(replay::StepKind(message.data) == haptic_node::kReevaluation ? num_reevaluations : num_cycles);
  });
  ASSERT_TRUE(read);
  EXPECT_GT(num_reevaluations, 100U);
  const lockstep::StepsOutcome outcome = ReplayHaptic(file, Load("touch"));
  EXPECT_EQ(outcome.num_steps, num_cycles + num_reevaluations);
  EXPECT_EQ(outcome.num_inexact, 0U);
  std::filesystem::remove(file);
}

TEST(Lockstep, ReevaluationChangesWhatTheBridgeGetsAndCanBeLeftOut) {
  scene::Scenario scenario = Load("touch");
  const lockstep::Outcome with = InLockstep(scenario);
  scenario.coupling.is_reevaluated = false;
  const lockstep::Outcome without = InLockstep(scenario);
  EXPECT_TRUE(with.is_completed);
  EXPECT_TRUE(without.is_completed);
  EXPECT_NE(with.hash, without.hash);
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

// The wrench is late by the device's own delay of 4 ms and by the loop's: that leaves 5 / (0.5 + 5) ms = 900 N/m of the
// 2500 N/m by the linear rule. The contact field is late by the device's alone: 5 / (0.5 + 4) ms = 1100 N/m. The exact
// limits are some 15 % lower.
TEST(Lockstep, ALateDeviceLowersTheStiffnessOfTheHandTheSameWayInEachRun) {
  scene::Scenario scenario = Load("touch");
  lockstep::Options options;
  options.duration_s = 6.0;
  const lockstep::Outcome in_time = InLockstep(scenario, options);
  EXPECT_GT(in_time.least_stiffness_share, 1.0);
  EXPECT_EQ(in_time.used_stiffness_share, 1.0);
  scenario.devices[0].command_delay_s = 4e-3;
  const lockstep::Outcome late = InLockstep(scenario, options);
  EXPECT_NEAR(late.least_stiffness_share, 0.37, 0.03);
  scenario.coupling.has_field = false;
  EXPECT_NEAR(InLockstep(scenario, options).least_stiffness_share, 0.3, 0.03);
  scenario.coupling.has_field = true;
  EXPECT_EQ(late.used_stiffness_share, late.least_stiffness_share);
  EXPECT_GE(late.least_energy_J, -1e-3);
  EXPECT_LT(late.share_made_passive, 0.01);
  EXPECT_EQ(late.hash, InLockstep(scenario, options).hash);
}

TEST(Lockstep, TheHandGetsNoEnergyAndThePassivityControllerSeldomActs) {
  const lockstep::Outcome outcome = InLockstep(Load("touch"));
  EXPECT_TRUE(outcome.is_completed);
  EXPECT_GE(outcome.least_energy_J, -1e-3);
  EXPECT_LT(outcome.share_made_passive, 0.01);
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
