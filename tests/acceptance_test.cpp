// Every scenario from start to end in lock-step: the procedure completes, force and momentum stay within their bounds,
// and no step of a real-time node allocates, locks or logs.

#include "tests/support/acceptance.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>

#include "tests/support.hpp"
#include "tests/support/step_watch.hpp"

namespace system_tests {
namespace {

// No step of these nodes allocates, locks or logs once warm, whatever happens in the scene. logic_node is not among
// them: it steps a hundred times a second in a process of its own, with texts, and no force waits for it.
void ExpectCleanSteps(const StepWatch& watch) {
  if (!StepWatch::is_possible()) return;
  for (const char* node : {"device_bridge", "haptic_node", "physics_node"}) {
    const StepWatch::Steps& steps = watch.of(node);
    EXPECT_GT(steps.count, StepWatch::kWarmSteps) << node;
    EXPECT_EQ(steps.dirty, 0u) << node << ": " << steps.allocations << " allocations and releases, " << steps.locks
                               << " locks, " << steps.logs << " log lines; the first at\n"
                               << steps.first;
  }
}

lockstep::Outcome RunWith(scene::Scenario scenario, scene::ContactInput input, std::uint64_t seed) {
  scenario.contact_input = input;
  lockstep::Options options;
  options.seed = seed;
  StepWatch watch;
  watch.Watch(&options);
  const lockstep::Outcome outcome = InLockstep(scenario, options);
  ExpectSound(scenario, outcome);
  ExpectCleanSteps(watch);
  return outcome;
}

TEST(Acceptance, CompletesTouchWithPlanes) {
  ExpectCompleted(RunWith(Load("touch"), scene::ContactInput::kPlanes, 1), kTouchSteps);
}

TEST(Acceptance, CompletesTouchWithThePapersWrench) {
  ExpectCompleted(RunWith(Load("touch"), scene::ContactInput::kWrench, 1), kTouchSteps);
}

TEST(Acceptance, CompletesTouchWithHardContact) {
  ExpectCompleted(RunWith(Load("touch"), scene::ContactInput::kManifold, 1), kTouchSteps);
}

TEST(Acceptance, CompletesTouchWithAnArmOfSevenJoints) {
  scene::Scenario scenario = Load("touch");
  scenario.devices.at(0).type = "simulated_hug";
  ExpectCompleted(RunWith(scenario, scene::ContactInput::kPlanes, 1), kTouchSteps);
}

TEST(Acceptance, ServiceRobotYieldsToAPushAndHoldsWhenLocked) {
  ExpectCompleted(RunWith(Load("service_robot"), scene::ContactInput::kPlanes, 1), {"push", "lock"});
}

TEST(Acceptance, CompletesPegInHoleWithPlanes) {
  ExpectCompleted(RunWith(Load("peg_in_hole"), scene::ContactInput::kPlanes, 1), kPegSteps);
}

TEST(Acceptance, CompletesPegInHoleWithThePapersWrench) {
  ExpectCompleted(RunWith(Load("peg_in_hole"), scene::ContactInput::kWrench, 1), kPegSteps);
}

TEST(Acceptance, CompletesPegInHoleWithHardContact) {
  ExpectCompleted(RunWith(Load("peg_in_hole"), scene::ContactInput::kManifold, 1), kPegSteps);
}

TEST(Acceptance, CompletesBothPegsWithTheMethodFast) {
  for (const char* name : {"peg_in_hole", "peg_in_hole/tight.xml"}) {  // 0.5 and 0.1 mm of clearance
    scene::Scenario scenario = Load(name);
    scenario.method = "fast";
    ExpectCompleted(RunWith(scenario, scene::ContactInput::kPlanes, 1), kPegSteps);
  }
}

TEST(Acceptance, CompletesTouchWithTheGodObject) {
  scene::Scenario scenario = Load("touch");
  scenario.method = "fast";
  scenario.coupling.type = "god_object";
  ExpectCompleted(RunWith(scenario, scene::ContactInput::kPlanes, 1), kTouchSteps);
}

TEST(Acceptance, ServiceRobotYieldsToAPushOfTheGodObject) {
  scene::Scenario scenario = Load("service_robot");
  scenario.method = "fast";
  scenario.coupling.type = "god_object";
  ExpectCompleted(RunWith(scenario, scene::ContactInput::kPlanes, 1), {"push", "lock"});
}

TEST(Acceptance, CompletesBothPegsWithTheGodObject) {
  for (const char* name : {"peg_in_hole", "peg_in_hole/tight.xml"}) {
    scene::Scenario scenario = Load(name);
    scenario.method = "fast";
    scenario.coupling.type = "god_object";
    ExpectCompleted(RunWith(scenario, scene::ContactInput::kPlanes, 1), kPegSteps);
  }
}

// Without a haptic device.
TEST(Acceptance, CompletesFreeCollision) {
  const lockstep::Outcome outcome = RunWith(Load("free_collision"), scene::ContactInput::kPlanes, 1);
  EXPECT_TRUE(outcome.is_completed) << outcome.why;
}

TEST(Acceptance, CompletesModuleReplacementWithTheMethodPaper) {
  scene::Scenario scenario = Load("module_replacement");
  ASSERT_EQ(scenario.method, "paper");
  ExpectCompleted(RunWith(scenario, scene::ContactInput::kPlanes, 1), kModuleSteps);
}

TEST(Acceptance, CompletesModuleReplacementWithTheMethodFast) {
  scene::Scenario scenario = Load("module_replacement");
  scenario.method = "fast";
  ExpectCompleted(RunWith(scenario, scene::ContactInput::kPlanes, 1), kModuleSteps);
}

TEST(Acceptance, CompletesModuleReplacementWithTheGodObject) {
  scene::Scenario scenario = Load("module_replacement");
  scenario.method = "fast";
  scenario.coupling.type = "god_object";
  ExpectCompleted(RunWith(scenario, scene::ContactInput::kPlanes, 1), kModuleSteps);
}

TEST(Acceptance, CoversEveryScenario) {
  const std::set<std::string> run{"touch", "service_robot", "peg_in_hole", "free_collision", "module_replacement"};
  std::set<std::string> shipped;
  for (const auto& entry : std::filesystem::directory_iterator(VR_OOS_SOURCE_DIR "/scenarios")) {
    if (exists(entry.path() / "scenario.xml")) shipped.insert(entry.path().filename().string());
  }
  EXPECT_EQ(shipped, run);
}

}  // namespace
}  // namespace system_tests
