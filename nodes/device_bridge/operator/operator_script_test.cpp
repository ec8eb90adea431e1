#include "nodes/device_bridge/operator/operator_script.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "core/names.hpp"

namespace device_bridge {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

scene::Scenario SmallScenario() {
  scene::Scenario scenario;
  scenario.objects.resize(2);
  scenario.objects[0].name = "handle";
  scenario.objects[0].owner = scene::Owner::kPhysics;
  scenario.objects[0].frames.push_back({"grip", {{1, 0, 0, 0}, {0.01, 0.02, 0.03}}});
  scenario.objects[1].name = "module";
  scenario.objects[1].frames.push_back({"hook", {}});
  scenario.mechanisms.resize(2);
  scenario.mechanisms[0].name = "latch";
  scenario.mechanisms[0].kind = scene::MechanismKind::kSnap;
  scenario.mechanisms[1].name = "switch";
  scenario.devices.resize(1);
  scenario.devices[0].role = "right";
  return scenario;
}

ParsedOperatorScript Parse(const std::string& text, const std::vector<std::string>& steps = {}) {
  return ParseOperatorScript(text, "operator.txt", SmallScenario(), steps);
}

std::string OnlyError(const std::string& text, const std::vector<std::string>& steps = {}) {
  const ParsedOperatorScript parsed = Parse(text, steps);
  EXPECT_EQ(parsed.diagnostics.size(), 1U) << text;
  return parsed.diagnostics.empty() ? "" : scene::Format(parsed.diagnostics[0]);
}

TEST(OperatorScript, ReadsEveryCommandOfTheReadme) {
  const ParsedOperatorScript parsed = Parse(R"(# comment
role right
step grasp
  reach handle.grip offset 0 0 0.1 turn 0 0 90 speed 0.3 within 0.004   # trailing comment
  grip 0.01 force 15
  wait until held handle
step insert
  carry handle.grip to module.hook offset 0 0 0.05
  push 0 0 -2 by 0.06 speed 0.04 until engaged latch
  push 1 0 0 by 0.01 until felt 12
  push 1 0 0 by 0.01
  wait 0.5
  wait until state switch 1
  wait until free latch
  wait until released
)");
  ASSERT_TRUE(parsed.diagnostics.empty()) << scene::Format(parsed.diagnostics[0]);
  ASSERT_EQ(parsed.script.steps.size(), 2U);
  const auto& grasp = parsed.script.steps[0].lines;
  ASSERT_EQ(grasp.size(), 3U);
  EXPECT_EQ(grasp[0].verb, Verb::kReach);
  EXPECT_EQ(grasp[0].line, 4);
  EXPECT_EQ(grasp[0].goal.object, 0);
  EXPECT_EQ(grasp[0].goal.X_OF.translation, glm::dvec3(0.01, 0.02, 0.03));
  EXPECT_EQ(grasp[0].X_FG.translation, glm::dvec3(0, 0, 0.1));
  EXPECT_NEAR(core::RotationVector(grasp[0].X_FG.rotation).z, 1.5707963267948966, 1e-12);
  EXPECT_EQ(grasp[0].speed_m_per_s, 0.3);
  EXPECT_EQ(grasp[0].within_m, 0.004);
  EXPECT_EQ(grasp[1].opening_m, 0.01);
  EXPECT_EQ(grasp[1].grip_strength_N, 15.0);
  EXPECT_EQ(grasp[2].until.kind, ConditionKind::kHeld);
  EXPECT_EQ(grasp[2].until.object, 0);
  const auto& insert = parsed.script.steps[1].lines;
  ASSERT_EQ(insert.size(), 8U);
  EXPECT_EQ(insert[0].speed_m_per_s, 0.15);
  EXPECT_EQ(insert[0].within_m, 0.002);
  EXPECT_EQ(insert[1].direction_W, glm::dvec3(0, 0, -1));
  EXPECT_EQ(insert[1].until.kind, ConditionKind::kEngaged);
  EXPECT_EQ(insert[2].until_felt_N, 12.0);
  EXPECT_EQ(insert[3].until.kind, ConditionKind::kNone);
  EXPECT_EQ(insert[4].seconds, 0.5);
  EXPECT_EQ(insert[5].until.mechanism, 1);
  EXPECT_EQ(insert[5].until.state, 1);
}

TEST(OperatorScript, ReportsLineCauseAndRemedyOfEveryError) {
  EXPECT_EQ(OnlyError("step a\nreach handle.gripp\n"), scene::Format({{"operator.txt", 2},
                                                                      "object 'handle' has no frame 'gripp'",
                                                                      "a frame must be named in scenario.xml",
                                                                      core::SuggestName("gripp", {"grip"})}));
  EXPECT_THAT(OnlyError("step a\nreach handel.grip"), HasSubstr("no object 'handel'"));
  EXPECT_THAT(OnlyError("step a\nreech handle.grip"), HasSubstr("no command 'reech'"));
  EXPECT_THAT(OnlyError("step a\npush 0 0 1 by 0.1 until engaged latsch"), HasSubstr("no mechanism 'latsch'"));
  EXPECT_THAT(OnlyError("step a\nwait until engaged switch"), HasSubstr("'switch' is not a snap"));
  EXPECT_THAT(OnlyError("step a\nwait until help"), HasSubstr("no condition 'help'"));
  EXPECT_THAT(OnlyError("step a\nwait until held modul"), HasSubstr("no object 'modul'"));
  EXPECT_THAT(OnlyError("step b\nwait 1", {"a"}), HasSubstr("operator.txt:1: no step 'b'"));
  EXPECT_THAT(OnlyError("step a\nwait 1\nstep a"), HasSubstr("twice"));
  EXPECT_THAT(OnlyError("wait 1"), HasSubstr("before the first step"));
  EXPECT_THAT(OnlyError("role left\nstep a"), HasSubstr("no role 'left'"));
  EXPECT_THAT(OnlyError("step a\npush 0 0 0 by 0.1"), HasSubstr("direction is 0 0 0"));
  EXPECT_THAT(OnlyError("step a\npush 0 0 1"), HasSubstr("'by' is missing"));
  EXPECT_THAT(OnlyError("step a\npush 0 0 1 by nan"), HasSubstr("'nan' is not a number"));
  EXPECT_THAT(OnlyError("step a\npush 0 0 1x by 1"), HasSubstr("'1x' is not a number"));
  EXPECT_THAT(OnlyError("step a\nreach handle.grip speed -1"), HasSubstr("must be from"));
  EXPECT_THAT(OnlyError("step a\nreach handle.grip fast"), HasSubstr("unexpected 'fast'"));
  EXPECT_THAT(OnlyError("step a\ngrip 0.5"), HasSubstr("the opening is 0.5"));
  EXPECT_THAT(OnlyError("step a\ncarry handle.grip module.hook"), HasSubstr("'to' is missing"));
  EXPECT_THAT(OnlyError("step a\nreach"), HasSubstr("is missing"));
  EXPECT_THAT(OnlyError("step"), HasSubstr("the step's name is missing"));
}

TEST(OperatorScript, ReportsAllErrorsAtOnce) {
  EXPECT_EQ(Parse("stepp a\nstep a\nreach nothing.here\nwait\n").diagnostics.size(), 3U);
}

TEST(OperatorScript, ARoleIsRequiredWithTwoDevices) {
  scene::Scenario scenario = SmallScenario();
  scenario.devices.resize(2);
  scenario.devices[1].role = "left";
  EXPECT_EQ(ParseOperatorScript("step a\nwait 1", "o.txt", scenario, {}).diagnostics.size(), 1U);
  const auto parsed = ParseOperatorScript("role left\nstep a\nwait 1\nrole right\nwait 1", "o.txt", scenario, {});
  ASSERT_TRUE(parsed.diagnostics.empty());
  EXPECT_EQ(parsed.script.steps[0].lines[0].role, 1);
  EXPECT_EQ(parsed.script.steps[0].lines[1].role, 0);
}

TEST(OperatorScript, ReadsTheStepsOfTheProcedureRegion) {
  const std::string file = ::testing::TempDir() + "operator_script_test.scxml";
  std::ofstream(file) << R"(<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0"><parallel id="all">
    <state id="procedure"><state id="first"><state id="inner"/></state><state id="second"/><final id="done"/></state>
    <state id="lamp"><state id="red"/></state></parallel></scxml>)";
  EXPECT_THAT(ReadStepNames(file), ElementsAre("first", "second"));
  EXPECT_TRUE(ReadStepNames(file + ".missing").empty());
}

TEST(OperatorScript, AMissingFileIsRefused) {
  scene::Scenario scenario = SmallScenario();
  EXPECT_TRUE(LoadOperatorScript(scenario).has_value());  // none named: an operator without work
  scenario.operator_script = "/nonexistent/operator.txt";
  const auto script = LoadOperatorScript(scenario);
  ASSERT_FALSE(script);
  EXPECT_THAT(script.error().detail, HasSubstr("/nonexistent/operator.txt"));
  EXPECT_EQ(CheckOperatorScript(scenario).size(), 1U);
}

}  // namespace
}  // namespace device_bridge
