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

// logic_node's steps handle texts and allocate (tests/step_guard/README.md), but neither wait nor log.
void ExpectNoLocksOrLogs(const StepWatch::Steps& steps) {
  EXPECT_GT(steps.count, 0u);
  EXPECT_EQ(steps.locks + steps.logs, 0u) << "logic_node: " << steps.locks << " locks, " << steps.logs << " log lines";
}

// No step of the nodes of the force loop allocates, locks or logs once warm, whatever happens in the scene.
void ExpectCleanSteps(const StepWatch& watch) {
  if (!StepWatch::is_possible()) return;
  ExpectNoLocksOrLogs(watch.of("logic_node"));
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

// The paper's method and coupling.
TEST(Acceptance, CompletesTouchWithPlanes) {
  ExpectCompleted(RunWith(LoadPaper("touch"), scene::ContactInput::kPlanes, 1), kTouchSteps);
}

TEST(Acceptance, CompletesTouchWithThePapersWrench) {
  ExpectCompleted(RunWith(LoadPaper("touch"), scene::ContactInput::kWrench, 1), kTouchSteps);
}

TEST(Acceptance, CompletesTouchWithHardContact) {
  ExpectCompleted(RunWith(LoadPaper("touch"), scene::ContactInput::kManifold, 1), kTouchSteps);
}

TEST(Acceptance, CompletesTouchWithAnArmOfSevenJoints) {
  scene::Scenario scenario = LoadPaper("touch");
  scenario.devices.at(0).type = "simulated_hug";
  ExpectCompleted(RunWith(scenario, scene::ContactInput::kPlanes, 1), kTouchSteps);
}

TEST(Acceptance, ServiceRobotYieldsToAPushAndHoldsWhenLocked) {
  ExpectCompleted(RunWith(LoadPaper("service_robot"), scene::ContactInput::kPlanes, 1), {"push", "lock"});
}

TEST(Acceptance, CompletesPegInHoleWithPlanes) {
  ExpectCompleted(RunWith(LoadPaper("peg_in_hole"), scene::ContactInput::kPlanes, 1), kPegSteps);
}

TEST(Acceptance, CompletesPegInHoleWithThePapersWrench) {
  ExpectCompleted(RunWith(LoadPaper("peg_in_hole"), scene::ContactInput::kWrench, 1), kPegSteps);
}

TEST(Acceptance, CompletesPegInHoleWithHardContact) {
  ExpectCompleted(RunWith(LoadPaper("peg_in_hole"), scene::ContactInput::kManifold, 1), kPegSteps);
}

TEST(Acceptance, CompletesBothPegsWithTheMethodFast) {
  for (const char* name : {"peg_in_hole", "peg_in_hole/tight.xml"}) {  // 0.5 and 0.1 mm of clearance
    scene::Scenario scenario = LoadPaper(name);
    scenario.method = "fast";
    ExpectCompleted(RunWith(scenario, scene::ContactInput::kPlanes, 1), kPegSteps);
  }
}

// As shipped: method fast, coupling god_object.
scene::Scenario LoadShipped(const std::string& name) {
  scene::Scenario scenario = Load(name);
  EXPECT_EQ(scenario.method, "fast") << name;
  EXPECT_EQ(scenario.coupling.type, "god_object") << name;
  return scenario;
}

TEST(Acceptance, CompletesTouchWithTheGodObject) {
  for (const scene::ContactInput input :
       {scene::ContactInput::kPlanes, scene::ContactInput::kManifold, scene::ContactInput::kWrench}) {
    ExpectCompleted(RunWith(LoadShipped("touch"), input, 1), kTouchSteps);
  }
}

TEST(Acceptance, ServiceRobotYieldsToAPushOfTheGodObject) {
  ExpectCompleted(RunWith(LoadShipped("service_robot"), scene::ContactInput::kPlanes, 1), {"push", "lock"});
}

TEST(Acceptance, CompletesBothPegsWithTheGodObject) {
  for (const char* name : {"peg_in_hole", "peg_in_hole/tight.xml"}) {
    ExpectCompleted(RunWith(LoadShipped(name), scene::ContactInput::kPlanes, 1), kPegSteps);
  }
}

TEST(Acceptance, CompletesThePegOnTheGround) {
  ExpectCompleted(RunWith(LoadShipped("peg_in_hole/ground.xml"), scene::ContactInput::kPlanes, 1), kPegSteps);
}

// Without a haptic device.
TEST(Acceptance, CompletesFreeCollision) {
  const lockstep::Outcome outcome = RunWith(Load("free_collision"), scene::ContactInput::kPlanes, 1);
  EXPECT_TRUE(outcome.is_completed) << outcome.why;
}

TEST(Acceptance, CompletesModuleReplacementWithTheMethodPaper) {
  ExpectCompleted(RunWith(LoadPaper("module_replacement"), scene::ContactInput::kPlanes, 1), kModuleSteps);
}

TEST(Acceptance, CompletesModuleReplacementWithTheMethodFast) {
  scene::Scenario scenario = LoadPaper("module_replacement");
  scenario.method = "fast";
  ExpectCompleted(RunWith(scenario, scene::ContactInput::kPlanes, 1), kModuleSteps);
}

TEST(Acceptance, CompletesModuleReplacementWithTheGodObject) {
  ExpectCompleted(RunWith(LoadShipped("module_replacement"), scene::ContactInput::kPlanes, 1), kModuleSteps);
}

TEST(Acceptance, CoversEveryScenario) {
  // Five fingers: FiveFingers.*.
  const std::set<std::string> run{"touch",          "service_robot",      "peg_in_hole", "five_fingers",
                                  "free_collision", "module_replacement", "two_hands"};
  std::set<std::string> shipped;
  for (const auto& entry : std::filesystem::directory_iterator(VR_OOS_SOURCE_DIR "/scenarios")) {
    // device_view has no end: Devices.ARobotIsShownWithoutAScene.
    if (exists(entry.path() / "scenario.xml") && entry.path().filename() != "device_view")
      shipped.insert(entry.path().filename().string());
  }
  EXPECT_EQ(shipped, run);
}

}  // namespace
}  // namespace system_tests
