// The module replacement by ten simulated operators, whose motion, errors and tremor differ by their seed.

#include <gtest/gtest.h>

#include "tests/support.hpp"
#include "tests/support/acceptance.hpp"

namespace system_tests {
namespace {

TEST(SlowSeeds, AtLeastNineOfTenCompleteTheModuleReplacement) {
  const scene::Scenario scenario = Load("module_replacement");
  int num_completed = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    lockstep::Options options;
    options.seed = seed;
    const lockstep::Outcome outcome = InLockstep(scenario, options);
    ExpectSound(scenario, outcome);
    EXPECT_EQ(outcome.steps.size(), kModuleSteps.size());
    num_completed += outcome.is_completed ? 1 : 0;
  }
  RecordProperty("completed", num_completed);
  EXPECT_GE(num_completed, 9);
}

// With the shipped coupling.
TEST(SlowSeeds, TheModuleReplacementIsCompletedWithEveryContactInput) {
  for (const scene::ContactInput input :
       {scene::ContactInput::kPlanes, scene::ContactInput::kWrench, scene::ContactInput::kManifold}) {
    scene::Scenario scenario = Load("module_replacement");
    scenario.contact_input = input;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      lockstep::Options options;
      options.seed = seed;
      const lockstep::Outcome outcome = InLockstep(scenario, options);
      ExpectSound(scenario, outcome);
      EXPECT_TRUE(outcome.is_completed) << "input " << static_cast<int>(input) << ": " << outcome.why;
    }
  }
}

// The small scenarios for other seeds: as shipped, and with all of the paper, its wrench included.
TEST(SlowSeeds, TouchAndPegInHoleWithBothContactInputs) {
  for (const char* name : {"touch", "peg_in_hole"}) {
    for (const scene::ContactInput input : {scene::ContactInput::kPlanes, scene::ContactInput::kWrench}) {
      scene::Scenario scenario = input == scene::ContactInput::kWrench ? LoadPaper(name) : Load(name);
      scenario.contact_input = input;
      for (std::uint64_t seed = 2; seed <= 5; ++seed) {
        lockstep::Options options;
        options.seed = seed;
        const lockstep::Outcome outcome = InLockstep(scenario, options);
        ExpectSound(scenario, outcome);
        EXPECT_TRUE(outcome.is_completed) << name << ", seed " << seed << ": " << outcome.why;
      }
    }
  }
}

}  // namespace
}  // namespace system_tests
