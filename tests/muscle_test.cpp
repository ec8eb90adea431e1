// A hand whose fingers press as the muscles of the forearm tell, in lock-step.
#include <gtest/gtest.h>

#include "tests/support.hpp"
#include "tests/support/acceptance.hpp"
#include "tests/support/step_watch.hpp"

namespace system_tests {
namespace {

TEST(Muscle, APegHeldByFrictionIsPutIntoItsHoleByAGripThatMusclesTell) {
  scene::Scenario scenario = Load("peg_in_hole/ground.xml");
  scenario.devices.at(0).options.emplace_back("muscle", "simulated");
  lockstep::Options options;
  StepWatch watch;
  watch.Watch(&options);
  const lockstep::Outcome outcome = InLockstep(scenario, options);
  EXPECT_TRUE(outcome.is_completed) << outcome.why;
  if (StepWatch::is_possible()) {
    const StepWatch::Steps& steps = watch.of("device_bridge");
    EXPECT_EQ(steps.dirty, 0u) << steps.first;
  }
}

}  // namespace
}  // namespace system_tests
