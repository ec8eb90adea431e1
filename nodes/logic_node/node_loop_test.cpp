#include "nodes/logic_node/node_loop.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "bus/membership/registry.hpp"
#include "core/clock.hpp"

namespace logic_node {
namespace {

using testing::HasSubstr;

constexpr std::uint64_t kSession = 77;
constexpr std::int64_t kPatience_ns = 20'000'000'000;  // exceeded only if something is broken

std::unique_ptr<bus::Node> MakeNode(const std::string& name, const std::string& registry) {
  bus::NodeOptions options;
  options.name = name;
  options.registry = registry;
  options.session = kSession;
  options.is_encrypted = false;
  options.sends_goodbye = false;
  auto node = bus::Node::Create(options);
  EXPECT_TRUE(node) << (node ? "" : node.error().detail);
  return std::move(*node);
}

// Two steps, and a parameter of each owner. The caller removes the procedure's file.
scene::Scenario TwoSteps() {
  scene::Scenario scenario;
  scenario.mechanisms.resize(1);
  scenario.mechanisms[0].name = "switch_a";
  scenario.mechanisms[0].detents_rad = {-0.3, 0.3};
  scenario.devices.resize(1);
  scenario.devices[0].role = "right";
  scenario.procedure =
      std::filesystem::path(testing::TempDir()) / ("vr_oos_loop_" + std::to_string(::getpid()) + ".scxml");
  std::ofstream(scenario.procedure) << R"(<scxml xmlns='http://www.w3.org/2005/07/scxml'
      xmlns:vr='urn:vr-oos:procedure'><state id="procedure">
    <state id="one"><onentry><vr:set name="force_cap_N" value="12"/><vr:set name="switch_a.detent_torque_Nm" value="0.5"/>
      </onentry><transition cond="switch_a.state == 1" target="two" vr:completes="true"/></state>
    <state id="two"><transition cond="switch_a.state == 0" target="done" vr:completes="true"/></state>
    <final id="done"/></state></scxml>)";
  return scenario;
}

// The real loop on the real bus; the test plays the other two nodes.
TEST(NodeLoop, RunsAProcedureSetsParametersAndFailsWhenANodeIsLost) {
  scene::Scenario scenario = TwoSteps();
  const std::filesystem::path report = scenario.procedure.string() + ".json";
  auto logic = LogicNode::Create(scenario);
  std::filesystem::remove(scenario.procedure);
  ASSERT_TRUE(logic) << logic.error().detail;

  auto registry = bus::Registry::Create({"tcp://127.0.0.1:0", kSession, "", false});
  ASSERT_TRUE(registry) << registry.error().detail;
  const std::string endpoint = (*registry)->endpoint();
  auto logic_bus = MakeNode("logic_node", endpoint);
  auto physics = MakeNode("physics_node", endpoint);
  auto haptic = MakeNode("haptic_node", endpoint);
  NodeLoop loop(scenario, logic->get(), logic_bus.get());
  loop.Declare();
  auto state_writer = physics->WriteLatest<core::PhysicsState>(bus::kPhysicsStateTopic);
  physics->OwnParameters({"switch_a.detent_torque_Nm"});
  haptic->OwnParameters({"force_cap_N"});
  auto& status = haptic->ReadState<core::LogicStatus>(bus::kLogicStatusTopic);
  for (bus::Node* node : {logic_bus.get(), physics.get(), haptic.get()}) {
    const auto started = node->Start();
    ASSERT_TRUE(started) << started.error().detail;
  }
  std::atomic<bool> stop{false};
  std::thread thread([&] { loop.Run(stop, report); });

  core::PhysicsState state;
  state.mechanisms.push_back({0, 0, 0.0, 0.0});
  std::map<std::string, double> at_physics;
  std::map<std::string, double> at_haptic;
  const auto answer = [&](bus::Node* node, const char* owned, std::map<std::string, double>* changes) {
    core::ParameterChange change;
    std::uint64_t ticket = 0;
    while (node->PollParameter(&change, &ticket)) {
      (*changes)[change.name] = change.value;
      node->AckParameter(ticket, state.tick, change.name == owned, "not mine");
    }
  };
  const auto play_until = [&](const std::function<bool()>& is_reached) {
    const std::int64_t deadline_ns = core::MonotonicNow_ns() + kPatience_ns;
    while (!is_reached() && core::MonotonicNow_ns() < deadline_ns) {
      haptic->Wait(core::MonotonicNow_ns() + core::kTick_ns);
      answer(haptic.get(), "force_cap_N", &at_haptic);
      if (physics == nullptr) continue;
      physics->Poll();
      answer(physics.get(), "switch_a.detent_torque_Nm", &at_physics);
      ++state.tick;
      state.time_ns = static_cast<std::int64_t>(state.tick) * core::kTick_ns;
      state_writer.Send(state);
    }
    return is_reached();
  };
  EXPECT_TRUE(play_until([&] { return status.has_value() && status.value().step == "one"; }));
  EXPECT_TRUE(play_until([&] { return !at_physics.empty() && !at_haptic.empty(); }));
  EXPECT_EQ(at_haptic, (std::map<std::string, double>{{"force_cap_N", 12.0}}));
  EXPECT_EQ(at_physics, (std::map<std::string, double>{{"switch_a.detent_torque_Nm", 0.5}}));
  state.mechanisms[0].state = 1;
  EXPECT_TRUE(play_until([&] { return status.value().step == "two"; }));

  physics.reset();  // without goodbye, as after kill -9
  const std::int64_t lost_ns = core::MonotonicNow_ns();
  EXPECT_TRUE(play_until([&] { return status.value().is_failed; }));
  EXPECT_LT(core::MonotonicNow_ns() - lost_ns, 2 * core::kNanosecondsPerSecond);
  EXPECT_EQ(status.value().why, "step two: physics_node was lost: it no longer answers");

  stop.store(true);
  thread.join();
  std::ifstream file(report);
  const nlohmann::json written = nlohmann::json::parse(file);
  std::filesystem::remove(report);
  EXPECT_FALSE(written.at("completed").get<bool>());
  EXPECT_THAT(written.at("why").get<std::string>(), HasSubstr("physics_node"));
  ASSERT_EQ(written.at("steps").size(), 2U);
  EXPECT_TRUE(written.at("steps")[0].at("completed").get<bool>());
  EXPECT_FALSE(written.at("steps")[1].at("completed").get<bool>());
  for (const auto& change : written.at("changes")) EXPECT_TRUE(change.at("accepted").get<bool>()) << change.dump();
}

// A supervisor restarts the lost node: the loop waits for it, resends its parameters, and continues. A restarted
// logic_node continues from its checkpoint.
TEST(NodeLoop, WaitsForALostNodeResendsItsParametersAndResumesFromACheckpoint) {
  scene::Scenario scenario = TwoSteps();
  const std::filesystem::path report = scenario.procedure.string() + ".json";
  const std::filesystem::path checkpoint = scenario.procedure.string() + ".checkpoint";
  auto logic = LogicNode::Create(scenario);
  auto later = LogicNode::Create(scenario);
  std::filesystem::remove(scenario.procedure);
  ASSERT_TRUE(logic && later);
  auto registry = bus::Registry::Create({"tcp://127.0.0.1:0", kSession, "", false});
  ASSERT_TRUE(registry) << registry.error().detail;
  const std::string endpoint = (*registry)->endpoint();
  auto logic_bus = MakeNode("logic_node", endpoint);
  NodeLoop loop(scenario, logic->get(), logic_bus.get());
  loop.Declare();
  loop.WaitForLostNodes(10 * kPatience_ns);
  loop.KeepCheckpoints(checkpoint);
  auto haptic = MakeNode("haptic_node", endpoint);
  haptic->OwnParameters({"force_cap_N"});
  auto& status = haptic->ReadState<core::LogicStatus>(bus::kLogicStatusTopic);
  ASSERT_TRUE(logic_bus->Start() && haptic->Start());
  std::atomic<bool> stop{false};
  std::thread thread([&] { loop.Run(stop, report); });

  core::PhysicsState state;
  state.mechanisms.push_back({0, 0, 0.0, 0.0});
  std::map<std::string, double> received;
  std::unique_ptr<bus::Node> physics;
  bus::LatestWriter<core::PhysicsState> state_writer;
  const auto begin = [&] {
    received.clear();
    physics = MakeNode("physics_node", endpoint);
    state_writer = physics->WriteLatest<core::PhysicsState>(bus::kPhysicsStateTopic);
    physics->OwnParameters({"switch_a.detent_torque_Nm"});
    return physics->Start().has_value();
  };
  const auto play_until = [&](const std::function<bool()>& is_reached) {
    const std::int64_t deadline_ns = core::MonotonicNow_ns() + kPatience_ns;
    while (!is_reached() && core::MonotonicNow_ns() < deadline_ns) {
      haptic->Wait(core::MonotonicNow_ns() + core::kTick_ns);
      core::ParameterChange change;
      std::uint64_t ticket = 0;
      while (haptic->PollParameter(&change, &ticket)) haptic->AckParameter(ticket, state.tick, true);
      if (physics == nullptr) continue;
      physics->Poll();
      while (physics->PollParameter(&change, &ticket)) {
        received[change.name] = change.value;
        physics->AckParameter(ticket, state.tick, true);
      }
      ++state.tick;
      state.time_ns = static_cast<std::int64_t>(state.tick) * core::kTick_ns;
      state_writer.Send(state);
    }
    return is_reached();
  };
  ASSERT_TRUE(begin());
  EXPECT_TRUE(play_until([&] { return !received.empty() && status.has_value() && status.value().step == "one"; }));
  state.mechanisms[0].state = 1;
  EXPECT_TRUE(play_until([&] { return status.value().step == "two"; }));
  physics.reset();
  EXPECT_TRUE(play_until([&] { return status.value().hint.find("physics_node is lost") == 0; }));
  EXPECT_FALSE(status.value().is_failed);
  ASSERT_TRUE(begin());
  EXPECT_TRUE(play_until([&] { return received.count("switch_a.detent_torque_Nm") == 1; }));
  EXPECT_EQ(received["switch_a.detent_torque_Nm"], 0.5);
  EXPECT_TRUE(play_until([&] { return status.value().hint.empty(); }));

  stop.store(true);
  thread.join();
  std::filesystem::remove(report);
  NodeLoop resumed(scenario, later->get(), logic_bus.get());
  const auto done = resumed.Resume(checkpoint);
  std::filesystem::remove(checkpoint);
  ASSERT_TRUE(done) << done.error().detail;
  EXPECT_EQ((*later)->status().step, "two");
  EXPECT_TRUE((*later)->steps()[0].is_completed);
}

}  // namespace
}  // namespace logic_node
