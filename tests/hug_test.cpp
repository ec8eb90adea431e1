// Procedures by the scripted operator with the arms of a simulated HUG, in lock-step.
#include <gtest/gtest.h>

#include "tests/support.hpp"
#include "tests/support/acceptance.hpp"
#include "tests/support/step_watch.hpp"

namespace system_tests {
namespace {

lockstep::Outcome ExpectCompletedWithHug(const scene::Scenario& scenario, const StepNames& names) {
  lockstep::Options options;
  StepWatch watch;
  watch.Watch(&options);
  const lockstep::Outcome outcome = InLockstep(scenario, options);
  ExpectSound(scenario, outcome);
  ExpectCompleted(outcome, names);
  if (StepWatch::is_possible()) {
    const StepWatch::Steps& steps = watch.of("device_bridge");
    EXPECT_EQ(steps.dirty, 0u) << steps.first;
  }
  return outcome;
}

TEST(Hug, CompletesTheModuleReplacement) {
  scene::Scenario scenario = Load("module_replacement");
  scenario.devices.at(0).type = "hug";
  ExpectCompletedWithHug(scenario, kModuleSteps);
}

// Once while it switches, once while it holds the old module. What the hand carried stays where it was until the arm is
// back: its state within a cycle, its force after two seconds.
TEST(Hug, FinishesTheModuleReplacementAlthoughItIsUnpluggedTwice) {
  scene::Scenario scenario = Load("module_replacement");
  scenario.devices.at(0).type = "hug";
  scenario.devices.at(0).options.emplace_back("faults", "unplug at 18 for 0.5; unplug at 45 for 0.5");
  ExpectCompletedWithHug(scenario, kModuleSteps);
}

TEST(Hug, ConnectsWithBothArmsWhatOneHandCannot) {
  const lockstep::Outcome outcome = ExpectCompletedWithHug(Load("two_hands"), {"hold", "take", "connect", "let_go"});
  // What one hand pushes into the module reaches the other: the account is of both.
  EXPECT_GE(outcome.least_energy_J, -1e-3);
  EXPECT_LT(outcome.share_made_passive, 0.01);
}

}  // namespace
}  // namespace system_tests
