#include "nodes/logic_node/logic_node.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "core/clock.hpp"
#include "scene/load_scenario.hpp"

namespace logic_node {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// A small scene in code: a switch, a latch, a module, a lamp, one hand.
scene::Scenario MakeScenario() {
  scene::Scenario scenario;
  scenario.stall_limit_s = 20.0;
  const auto add = [&](const char* name, scene::Owner owner) {
    scene::Object object;
    object.name = name;
    object.owner = owner;
    scenario.objects.push_back(object);
  };
  add("cavity", scene::Owner::kFixed);
  add("module", scene::Owner::kPhysics);
  add("lamp", scene::Owner::kFixed);
  add("palm", scene::Owner::kHand);
  scenario.objects[0].X_WO.translation = {1.0, 0.0, 0.0};
  scenario.objects[2].is_lamp = true;
  scenario.objects[2].lamp_color = {0.0f, 1.0f, 0.0f};
  scenario.pairs.resize(1);
  scenario.pairs[0].sampled = 1;
  scenario.pairs[0].field = 0;
  scenario.mechanisms.resize(2);
  scenario.mechanisms[0].name = "switch_a";
  scenario.mechanisms[1].name = "latch_a";
  scenario.mechanisms[1].kind = scene::MechanismKind::kSnap;
  scenario.devices.resize(1);
  scenario.devices[0].role = "op1/arm.left";
  return scenario;
}

constexpr const char* kProcedure = R"(
<parallel id="all">
  <state id="procedure">
    <state id="switch_off">
      <onentry><vr:hint text="Switch it off"/><vr:set name="force_cap_N" value="20"/></onentry>
      <onexit><vr:set name="force_cap_N" value="40"/></onexit>
      <transition cond="switch_a.state == 0" target="insert_new" vr:completes="true"/>
    </state>
    <state id="insert_new">
      <transition cond="module.distance.cavity &lt; 0.1 &amp;&amp; latch_a.state == 1" target="let_go" vr:completes="true"/>
      <transition event="give_up" target="done"/>
    </state>
    <state id="let_go">
      <transition cond="!op1/arm.left.grasped.module" target="done" vr:completes="true"/>
    </state>
    <final id="done"/>
  </state>
  <state id="lamp_region">
    <state id="green"><transition cond="switch_a.state == 0" target="red"/></state>
    <state id="red"><onentry><vr:lamp object="lamp" color="1 0 0"/>
      <vr:set name="latch_a.release_force_N" value="5 + 2 * 5"/></onentry></state>
  </state>
</parallel>)";

class LogicNodeTest : public testing::Test {
 protected:
  void Load(const std::string& body) {
    scenario_ = MakeScenario();
    scenario_.procedure =
        std::filesystem::path(testing::TempDir()) / ("vr_oos_logic_" + std::to_string(::getpid()) + ".scxml");
    std::ofstream(scenario_.procedure) << "<scxml xmlns='http://www.w3.org/2005/07/scxml' "
                                          "xmlns:vr='urn:vr-oos:procedure' version='1.0'>"
                                       << body << "</scxml>";
    auto node = LogicNode::Create(scenario_);
    std::filesystem::remove(scenario_.procedure);
    ASSERT_TRUE(node) << node.error().detail;
    node_ = std::move(*node);
    physics_.header.sequence = 1;
    physics_.mechanisms.push_back({0, 1, 0.35, 0.0});
    physics_.mechanisms.push_back({1, 0, 0.05, 0.0});
    physics_.bodies.push_back({1, {}, {}});
    inputs_.physics = &physics_;
    inputs_.grasped_objects = {1};
  }
  const core::LogicStatus& Step(std::int64_t duration_ns = kStepPeriod_ns) {
    inputs_.now_ns += duration_ns;
    node_->Step(inputs_, &outputs_);
    inputs_.events.clear();
    return outputs_.status;
  }
  [[nodiscard]] std::vector<std::pair<std::string, double>> Changes() const {
    std::vector<std::pair<std::string, double>> changes;
    for (const core::ParameterChange& change : outputs_.changes) changes.emplace_back(change.name, change.value);
    return changes;
  }

  scene::Scenario scenario_;
  std::unique_ptr<LogicNode> node_;
  core::PhysicsState physics_;
  Inputs inputs_;
  Outputs outputs_;
};

TEST_F(LogicNodeTest, WaitsForTheFirstPhysicsState) {
  Load(kProcedure);
  inputs_.physics = nullptr;
  EXPECT_EQ(Step().step, "");
  EXPECT_THAT(outputs_.status.hint, HasSubstr("physics_node"));
  EXPECT_TRUE(outputs_.changes.empty());
  const core::PhysicsState never;
  inputs_.physics = &never;
  EXPECT_EQ(Step().step, "");
  inputs_.physics = &physics_;
  EXPECT_EQ(Step().step, "switch_off");
}

TEST_F(LogicNodeTest, RunsTheProcedureToItsEnd) {
  Load(kProcedure);
  Step();
  EXPECT_EQ(outputs_.status.step, "switch_off");
  EXPECT_EQ(outputs_.status.hint, "Switch it off");
  EXPECT_TRUE(outputs_.is_status_changed);
  EXPECT_THAT(Changes(), ElementsAre(std::pair<std::string, double>("force_cap_N", 20.0)));
  ASSERT_EQ(outputs_.status.lamps.size(), 1U);
  EXPECT_EQ(outputs_.status.lamps[0].green, 1.0f);
  Step();
  EXPECT_FALSE(outputs_.is_status_changed);
  EXPECT_TRUE(outputs_.changes.empty());

  physics_.mechanisms[0].state = 0;
  Step(2 * core::kNanosecondsPerSecond);
  EXPECT_EQ(outputs_.status.step, "insert_new");
  EXPECT_EQ(outputs_.status.lamps[0].red, 1.0f);
  EXPECT_EQ(outputs_.status.lamps[0].green, 0.0f);
  EXPECT_THAT(Changes(), ElementsAre(std::pair<std::string, double>("force_cap_N", 40.0),
                                     std::pair<std::string, double>("latch_a.release_force_N", 15.0)));
  EXPECT_THAT(outputs_.status.active_states, ElementsAre("all", "procedure", "insert_new", "lamp_region", "red"));

  physics_.mechanisms[1].state = 1;
  EXPECT_EQ(Step().step, "insert_new");  // the module is a metre away
  physics_.bodies[0].X_WO.translation = {0.95, 0.0, 0.0};
  EXPECT_EQ(Step().step, "let_go");
  EXPECT_FALSE(Step().is_final);
  inputs_.grasped_objects = {core::kNoObject};
  Step(core::kNanosecondsPerSecond);
  EXPECT_TRUE(outputs_.status.is_final);
  EXPECT_FALSE(outputs_.status.is_failed);

  const auto steps = node_->steps();
  ASSERT_EQ(steps.size(), 3U);
  EXPECT_NEAR(steps[0].seconds, 2.01, 1e-9);
  EXPECT_NEAR(steps[1].seconds, 0.02, 1e-9);
  EXPECT_NEAR(steps[2].seconds, 1.01, 1e-9);
  for (const StepRecord& step : steps) EXPECT_TRUE(step.is_completed && step.why.empty()) << step.name;
}

TEST_F(LogicNodeTest, AStallReportsTheStepAndItsUnmetCondition) {
  Load(kProcedure);
  physics_.mechanisms[0].state = 0;
  physics_.bodies[0].X_WO.translation = {0.95, 0.0, 0.0};
  Step();
  for (int i = 0; i < 2000; ++i) EXPECT_FALSE(Step().is_failed) << i;
  Step();
  EXPECT_TRUE(outputs_.status.is_failed);
  EXPECT_EQ(outputs_.status.why, "step insert_new: no progress for 20 s; waiting for latch_a.state == 1, which is 0");
  const auto steps = node_->steps();
  EXPECT_TRUE(steps[0].is_completed);
  EXPECT_FALSE(steps[1].is_completed);
  EXPECT_EQ(steps[1].why, outputs_.status.why);
  EXPECT_EQ(steps[2].why, "not reached");
  // A failure is final.
  physics_.mechanisms[1].state = 1;
  Step();
  EXPECT_EQ(outputs_.status.step, "insert_new");
  EXPECT_TRUE(outputs_.status.is_failed);
}

TEST_F(LogicNodeTest, EndingWithoutCompletionIsAFailureOfThatStep) {
  Load(kProcedure);
  physics_.mechanisms[0].state = 0;
  Step();
  inputs_.events.push_back({0, "operator", "give_up", ""});
  Step();
  EXPECT_TRUE(outputs_.status.is_final);
  EXPECT_TRUE(outputs_.status.is_failed);
  EXPECT_THAT(outputs_.status.why, HasSubstr("step insert_new"));
  EXPECT_THAT(node_->steps()[1].why, HasSubstr("does not complete it"));
}

TEST_F(LogicNodeTest, ALostNodeIsReportedAndAGoneOneFailsTheProcedure) {
  Load(kProcedure);
  Step();
  inputs_.events.push_back({0, "bus", "node_lost", "visual_node"});
  Step();
  EXPECT_FALSE(outputs_.status.is_failed);
  EXPECT_EQ(outputs_.status.hint, "visual_node is lost; Switch it off");
  inputs_.events.push_back({0, "bus", "node_found", "visual_node"});
  EXPECT_EQ(Step().hint, "Switch it off");
  // Bus time stands still without physics_node: the event alone must suffice.
  inputs_.events.push_back({0, "bus", "node_lost", "physics_node"});
  Step(0);
  EXPECT_FALSE(outputs_.status.is_failed);
  EXPECT_EQ(outputs_.status.hint, "physics_node is lost; Switch it off");
  inputs_.events.push_back({0, "logic_node", kNodeGone, "physics_node"});
  Step(0);
  EXPECT_TRUE(outputs_.status.is_failed);
  EXPECT_EQ(outputs_.status.why, "step switch_off: physics_node was lost: it no longer answers");
  EXPECT_THAT(outputs_.status.hint, HasSubstr("physics_node is lost"));
}

TEST_F(LogicNodeTest, AViewerThatLeavesIsNotLost) {
  Load(kProcedure);
  Step();
  inputs_.events.push_back({0, "bus", "node_left", "visual_node-7"});
  EXPECT_EQ(Step().hint, "Switch it off");
  inputs_.events.push_back({0, "bus", "node_left", "haptic_node"});
  EXPECT_EQ(Step().hint, "haptic_node is lost; Switch it off");
}

TEST_F(LogicNodeTest, AStepDoesNotStallWhileANodeThatItNeedsIsLost) {
  Load(kProcedure);
  const auto limit_ns = static_cast<std::int64_t>(scenario_.stall_limit_s * 1e9);
  Step();
  inputs_.events.push_back({0, "bus", "node_lost", "haptic_node"});
  Step(3 * limit_ns);
  EXPECT_FALSE(outputs_.status.is_failed) << outputs_.status.why;
  inputs_.events.push_back({0, "bus", "node_found", "haptic_node"});
  EXPECT_FALSE(Step(limit_ns / 2).is_failed);
  EXPECT_TRUE(Step(limit_ns).is_failed);
}

TEST_F(LogicNodeTest, ANodeThatLeavesAfterTheEndIsNoFailure) {
  Load(kProcedure);
  physics_.mechanisms[0].state = 0;
  physics_.mechanisms[1].state = 1;
  physics_.bodies[0].X_WO.translation = {0.95, 0.0, 0.0};
  inputs_.grasped_objects = {core::kNoObject};
  Step();
  ASSERT_TRUE(outputs_.status.is_final);
  inputs_.events.push_back({0, "bus", "node_left", "haptic_node"});
  EXPECT_FALSE(Step().is_failed);
}

TEST_F(LogicNodeTest, EventsAreNamedWithTheirDetail) {
  EXPECT_EQ(EventName({0, "physics_node", "snap_engaged", "latch_a"}), "snap_engaged.latch_a");
  EXPECT_EQ(EventName({0, "physics_node", "grasp_attached", "right module"}), "grasp_attached.right.module");
  EXPECT_EQ(EventName({0, "x", "give_up", ""}), "give_up");
}

TEST_F(LogicNodeTest, AnEndlessLoopOfTransitionsIsAFailure) {
  Load(R"(<state id="procedure"><state id="a"><transition cond="switch_a.state == 1" target="b" vr:completes="true"/>
    </state><state id="b"><transition cond="switch_a.state == 1" target="a" vr:completes="true"/>
    <transition event="e" target="done"/></state><final id="done"/></state>)");
  EXPECT_TRUE(Step().is_failed);
  EXPECT_THAT(outputs_.status.why, HasSubstr("endlessly"));
}

TEST(Procedure, RefusesUnknownNamesWithLineAndRemedy) {
  scene::Scenario scenario = MakeScenario();
  scenario.procedure =
      std::filesystem::path(testing::TempDir()) / ("vr_oos_procedure_" + std::to_string(::getpid()) + ".scxml");
  const auto complaint =
      [&](const std::string& body) {
        std::ofstream(scenario.procedure)
            << "<scxml xmlns='http://www.w3.org/2005/07/scxml' xmlns:vr='urn:vr-oos:procedure'>\n<state id='procedure'>"
               "<state id='one'>\n"
            << body
            << "\n<transition event='e' target='done' vr:completes='true'/></state><final id='done'/></state></scxml>";
        const auto diagnostics = CheckProcedure(scenario);
        std::filesystem::remove(scenario.procedure);
        return diagnostics.empty() ? std::string() : scene::Format(diagnostics.front());
      };
  const auto signal = [](const std::string& name) { return "<transition cond='" + name + " == 1' target='done'/>"; };
  const auto set = [](const std::string& name) { return "<onentry><vr:set name='" + name + "' value='1'/></onentry>"; };
  for (const char* good : {"switch_a.state", "latch_a.position", "module.z", "cavity.x", "op1/arm.left.grasped.module",
                           "module.distance.cavity"}) {
    EXPECT_EQ(complaint(signal(good)), "") << good;
  }
  for (const char* good : {"force_cap_N", "pair.module/cavity.active", "latch_a.release_force_N"}) {
    EXPECT_EQ(complaint(set(good)), "") << good;
  }
  EXPECT_THAT(complaint(signal("latch_b.state")), HasSubstr(".scxml:3: "));
  EXPECT_THAT(complaint(signal("latch_b.state")), HasSubstr("did you mean 'latch_a.state'"));
  EXPECT_THAT(complaint(signal("palm.x")), HasSubstr("unknown name 'palm.x'"));
  EXPECT_THAT(complaint(signal("left.grasped.module")), HasSubstr("unknown name"));
  EXPECT_THAT(complaint(set("pair.module/cavty.active")), HasSubstr("did you mean 'pair.module/cavity.active'"));
  EXPECT_THAT(complaint(set("switch_a.release_force_N")), HasSubstr("unknown parameter"));
  EXPECT_THAT(complaint("<onentry><vr:lamp object='cavity' color='1 0 0'/></onentry>"), HasSubstr("not a lamp"));
}

TEST(Procedure, ThoseOfTheShippedScenariosAreValid) {
  for (const char* name : {"touch", "peg_in_hole", "module_replacement"}) {
    const auto scenario = scene::LoadScenario(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios" / name);
    ASSERT_TRUE(scenario) << scene::Format(scenario.error().front());
    for (const scene::Diagnostic& diagnostic : CheckProcedure(*scenario)) ADD_FAILURE() << scene::Format(diagnostic);
  }
}

}  // namespace
}  // namespace logic_node
