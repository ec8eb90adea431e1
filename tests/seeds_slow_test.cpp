// The module replacement by simulated operators, whose motion, errors and tremor differ by their seed.

#include <gtest/gtest.h>

#include "tests/support.hpp"
#include "tests/support/acceptance.hpp"
#include "tools/oos/run/session/session.hpp"

namespace system_tests {
namespace {

TEST(SlowSeeds, TwentyOperatorsCompleteTheModuleReplacement) {
  const scene::Scenario scenario = Load("module_replacement");
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    lockstep::Options options;
    options.seed = seed;
    const lockstep::Outcome outcome = InLockstep(scenario, options);
    ExpectSound(scenario, outcome);
    EXPECT_EQ(outcome.steps.size(), kModuleSteps.size()) << "seed " << seed;
    EXPECT_TRUE(outcome.is_completed) << "seed " << seed << ": " << outcome.why;
  }
}

TEST(SlowSeeds, ThreeOperatorsCompleteTheModuleReplacementLive) {
  const scene::Scenario scenario = Load("module_replacement");
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    oos::SessionOptions options;
    options.seed = seed;
    options.out = std::filesystem::path(VR_OOS_BINARY_DIR) / "live_seeds" / std::to_string(seed);
    options.without = {"visual_node"};
    options.program_folder = std::filesystem::path(VR_OOS_BINARY_DIR) / "bin";
    std::filesystem::remove_all(options.out);
    std::filesystem::create_directories(options.out);
    const auto outcome = oos::RunSession(scenario, options);
    ASSERT_TRUE(outcome) << outcome.error().detail;
    EXPECT_TRUE(outcome->is_final) << "seed " << seed << ": " << outcome->why;
  }
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
