// One thing is broken on purpose, and the run must fail in the step that needs it.

#include "tests/support/sabotage.hpp"

#include <gtest/gtest.h>

#include "tests/support.hpp"
#include "tests/support/acceptance.hpp"
#include "tests/support/scenario_copy.hpp"

namespace system_tests {
namespace {

TEST(Sabotage, AModule3mmTooWideIsNotInserted) {
  ScenarioCopy copy("module_replacement", "wide");
  const std::string text = copy.Read("scenario.xml");
  const std::size_t object = text.find("<object name=\"module_new\"");
  const std::string mesh = "<collision mesh=\"meshes/module.obj\"";
  const std::size_t at = text.find(mesh, object);
  ASSERT_NE(at, std::string::npos);
  copy.Write("scenario.xml", std::string(text).replace(at, mesh.size(), "<collision mesh=\"meshes/module_wide.obj\""));
  ExpectFailedIn(RunSabotaged(copy.Load()), kModuleSteps, "insert_new", "latch_a_new");
}

TEST(Sabotage, AStuckSwitchIsNotSwitchedOff) {
  ScenarioCopy copy("module_replacement", "stuck");
  copy.Replace("scenario.xml", "locked=\"false\"", "locked=\"true\"");
  ExpectFailedIn(RunSabotaged(copy.Load()), kModuleSteps, "switch_off", "switch_a");
}

// The cavity's chamfer is what leads the module in: an operator who aims a few millimetres beside it does not find the
// latch when nothing is felt.
TEST(Sabotage, WithoutContactBetweenModuleAndCavityTheNewModuleDoesNotSnap) {
  scene::Scenario scenario = Load("module_replacement");
  scenario.pairs[PairOf(scenario, "module_new", "cavity_a")].is_active = false;
  ExpectFailedIn(RunSabotaged(scenario), kModuleSteps, "insert_new", "latch_a_new");
}

TEST(Sabotage, WithoutContactBetweenJawsAndHandleItIsNotGrasped) {
  scene::Scenario scenario = Load("module_replacement");
  SwitchOffJaws(&scenario, "handle");
  ExpectFailedIn(RunSabotaged(scenario), kModuleSteps, "grasp", "handle");
}

// No contact force reaches physics_node.
TEST(Sabotage, WithoutContactsAtPhysicsTheFirstStepFails) {
  lockstep::Options options;
  options.loses_physics_wrench = true;
  ExpectFailedIn(RunSabotaged(Load("module_replacement"), options), kModuleSteps, "cover", "cover_hold");
  ExpectFailedIn(RunSabotaged(Load("peg_in_hole"), options), kPegSteps, "grasp", "peg");
  ExpectFailedIn(RunSabotaged(Load("touch"), options), kTouchSteps, "press", "pad");
}

TEST(Sabotage, WithoutContactBetweenPegAndHoleThePegGoesThroughTheFloor) {
  scene::Scenario scenario = Load("peg_in_hole");
  scenario.pairs[PairOf(scenario, "peg", "hole")].is_active = false;
  ExpectFailedIn(RunSabotaged(scenario), kPegSteps, "insert", "peg");
}

}  // namespace
}  // namespace system_tests
