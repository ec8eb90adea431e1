#include "nodes/device_bridge/node_loop.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "bus/membership/registry.hpp"
#include "core/clock.hpp"
#include "nodes/device_bridge/head/make_heads.hpp"

namespace device_bridge {
namespace {

constexpr std::uint64_t kSession = 4711;

bus::NodeOptions NodeNamed(const std::string& name, const bus::Registry& registry) {
  bus::NodeOptions options;
  options.name = name;
  options.registry = registry.endpoint();
  options.session = kSession;
  options.is_encrypted = false;
  return options;
}

nlohmann::json ReadJson(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return nlohmann::json::parse(stream);
}

// Over the real bus, with a source that answers every sample with a command of 10 N and then stops.
TEST(NodeLoop, ClosesTheLoopOverTheBusAndDropsTheForceWhenCommandsStop) {
  scene::Scenario scenario;
  scenario.name = "bus";
  scenario.duration_limit_s = 10.0;
  scenario.devices.resize(1);
  scenario.devices[0].role = "op1/arm.left";
  scenario.users.emplace_back().name = "op1";
  auto registry = bus::Registry::Create({"tcp://127.0.0.1:0", kSession, "", false});
  ASSERT_TRUE(registry) << registry.error().detail;

  Options options;
  options.clock = core::MonotonicNow_ns;
  auto bridge = DeviceBridge::Create(scenario, 1, options);
  ASSERT_TRUE(bridge) << bridge.error().detail;
  auto bridge_node = bus::Node::Create(NodeNamed("device_bridge", **registry));
  ASSERT_TRUE(bridge_node) << bridge_node.error().detail;
  auto heads = MakeHeads(scenario.users, 1);
  ASSERT_TRUE(heads) << heads.error().detail;
  NodeLoop loop(scenario, std::move(*heads), nullptr, bridge->get(), bridge_node->get());
  loop.Declare();
  ASSERT_TRUE((*bridge_node)->Start());

  auto source = bus::Node::Create(NodeNamed("haptic_node", **registry));
  ASSERT_TRUE(source) << source.error().detail;
  auto& states = (*source)->ReadLatest<core::DeviceState>(bus::DeviceStateTopic("op1/arm.left"));
  auto writer = (*source)->WriteLatest<core::DeviceCommand>(bus::DeviceCommandTopic("op1/arm.left"));
  const auto& head = (*source)->ReadLatest<core::HeadState>(bus::HeadTopic("op1"));
  (*source)->ReadEvents();
  ASSERT_TRUE((*source)->Start());

  std::atomic<bool> stop{false};
  std::thread thread([&] { loop.Run(stop); });
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  std::uint64_t echoed = 0;
  // The number of samples of one second, however slow the machine is (30 s at most).
  while (echoed < 1000 && core::MonotonicNow_ns() - begin_ns < 30'000'000'000) {
    (*source)->Wait(core::MonotonicNow_ns() + 10'000'000);
    if (!states.is_fresh()) continue;
    core::DeviceCommand command;
    command.F_Do_W.force_N = {0, 0, 10};
    command.header.direct = states.value().header.direct;
    command.header.through_physics = states.value().header.direct;
    writer.Send(command);
    ++echoed;
  }
  // Send nothing until the bridge reports it.
  core::Event event;
  bool has_faded = false;
  const std::int64_t silent_ns = core::MonotonicNow_ns();
  while (!has_faded && core::MonotonicNow_ns() - silent_ns < 10'000'000'000) {
    (*source)->Wait(core::MonotonicNow_ns() + 10'000'000);
    while ((*source)->PollEvent(&event))
      has_faded = has_faded || (event.name == "force_faded" && event.source == "device_bridge");
  }
  EXPECT_TRUE(has_faded);
  stop = true;
  thread.join();

  EXPECT_EQ(echoed, 1000U);
  EXPECT_GT(head.value().header.sequence, 100U) << "125 a second";
  EXPECT_TRUE(head.value().is_simulated);
  EXPECT_NE(head.value().X_RH.translation, glm::dvec3(0.0));
  const std::filesystem::path folder = ::testing::TempDir();
  ASSERT_TRUE(loop.WriteReport(folder, false));
  const nlohmann::json report = ReadJson(folder / "device_bridge.json");
  const nlohmann::json& role = report.at("roles").at(0);
  EXPECT_GT(report.at("peak_force_N").get<double>(), 1.0);
  EXPECT_LE(report.at("peak_force_N").get<double>(), 10.0);
  EXPECT_LT(role.at("oldest_force_ms").get<double>(), 60.0);
  EXPECT_GE(role.at("link_losses").get<int>(), 1);
  EXPECT_EQ(report.at("samples_over_cap").get<int>(), 0);
  EXPECT_GT(report.at("direct_ms").at("n").get<int>(), 500);
  EXPECT_GT(report.at("direct_ms").at("mean").get<double>(), 0.0);
  EXPECT_EQ(report.at("echoes_unknown").get<int>(), 0);
  std::ifstream table(folder / "device_bridge_latency.csv");
  std::string header, row;
  std::getline(table, header);
  std::getline(table, row);
  EXPECT_EQ(header, "chain,trace_id,origin_ns,echo_ns,stages");
  EXPECT_EQ(row.rfind("direct,", 0), 0U);
  EXPECT_FALSE(loop.WriteReport(folder / "no" / "such" / "folder", false));
}

}  // namespace
}  // namespace device_bridge
