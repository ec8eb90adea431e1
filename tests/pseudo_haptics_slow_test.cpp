// The module replacement by a hand that is tracked and feels nothing, with each method of pseudo-haptics.

#include <gtest/gtest.h>

#include <string>

#include "tests/support.hpp"
#include "tests/support/acceptance.hpp"

namespace system_tests {
namespace {

TEST(SlowPseudoHaptics, EachMethodCompletesTheModuleReplacement) {
  for (const char* method : {"stick", "distance", "pinch"}) {
    scene::Scenario scenario = Load("module_replacement");
    scenario.devices.at(0).type = "simulated_hand";
    scenario.devices.at(0).options = {{"grip", method}};
    lockstep::Options options;
    options.seed = 1;
    const lockstep::Outcome outcome = InLockstep(scenario, options);
    ExpectSound(scenario, outcome);
    EXPECT_EQ(outcome.steps.size(), kModuleSteps.size()) << method;
    EXPECT_TRUE(outcome.is_completed) << method << ": " << outcome.why;
  }
}

}  // namespace
}  // namespace system_tests
