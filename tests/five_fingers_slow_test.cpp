// The module replacement by a hand with five fingers: the deformable cover by its tab, the switch, the handle tool,
// both modules.

#include <gtest/gtest.h>

#include "tests/support.hpp"
#include "tests/support/acceptance.hpp"

namespace system_tests {
namespace {

TEST(SlowFiveFingers, CompleteTheModuleReplacement) {
  const scene::Scenario scenario = Load("module_replacement/five_fingers.xml");
  const lockstep::Outcome outcome = InLockstep(scenario);
  ExpectSound(scenario, outcome);
  EXPECT_EQ(outcome.steps.size(), kModuleSteps.size());
  EXPECT_TRUE(outcome.is_completed) << outcome.why;
}

}  // namespace
}  // namespace system_tests
