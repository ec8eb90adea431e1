// The scenarios from start to end in lock-step: what a run must hold.

#include "tests/support/acceptance.hpp"

#include <gtest/gtest.h>

#include "tests/support.hpp"

namespace system_tests {
namespace {

oos::LockstepOutcome RunWith(scene::Scenario scenario, scene::ContactInput input, std::uint64_t seed) {
  scenario.contact_input = input;
  oos::LockstepOptions options;
  options.seed = seed;
  const oos::LockstepOutcome outcome = InLockstep(scenario, options);
  ExpectSound(scenario, outcome);
  return outcome;
}

TEST(Acceptance, TouchWithPlanes) {
  ExpectCompleted(RunWith(Load("touch"), scene::ContactInput::kPlanes, 1), kTouchSteps);
}

TEST(Acceptance, TouchWithThePapersWrench) {
  ExpectCompleted(RunWith(Load("touch"), scene::ContactInput::kWrench, 1), kTouchSteps);
}

TEST(Acceptance, TouchWithHardContact) {
  ExpectCompleted(RunWith(Load("touch"), scene::ContactInput::kManifold, 1), kTouchSteps);
}

TEST(Acceptance, TouchWithAnArmOfSevenJoints) {
  scene::Scenario scenario = Load("touch");
  scenario.devices.at(0).type = "simulated_hug";
  ExpectCompleted(RunWith(scenario, scene::ContactInput::kPlanes, 1), kTouchSteps);
}

TEST(Acceptance, ServiceRobotYieldsToAPushAndHoldsWhenLocked) {
  ExpectCompleted(RunWith(Load("service_robot"), scene::ContactInput::kPlanes, 1), {"push", "lock"});
}

TEST(Acceptance, PegInHoleWithPlanes) {
  ExpectCompleted(RunWith(Load("peg_in_hole"), scene::ContactInput::kPlanes, 1), kPegSteps);
}

TEST(Acceptance, PegInHoleWithThePapersWrench) {
  ExpectCompleted(RunWith(Load("peg_in_hole"), scene::ContactInput::kWrench, 1), kPegSteps);
}

TEST(Acceptance, PegInHoleWithHardContact) {
  ExpectCompleted(RunWith(Load("peg_in_hole"), scene::ContactInput::kManifold, 1), kPegSteps);
}

TEST(Acceptance, PegsWithTheMethodFast) {
  for (const char* name : {"peg_in_hole", "peg_in_hole/tight.xml"}) {  // 0.5 and 0.1 mm of clearance
    scene::Scenario scenario = Load(name);
    scenario.method = "fast";
    ExpectCompleted(RunWith(scenario, scene::ContactInput::kPlanes, 1), kPegSteps);
  }
}

TEST(Acceptance, ModuleReplacementWithSeed1) {
  ExpectCompleted(RunWith(Load("module_replacement"), scene::ContactInput::kPlanes, 1), kModuleSteps);
}

}  // namespace
}  // namespace system_tests
