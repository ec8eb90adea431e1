#include "nodes/device_bridge/device_bridge.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "nodes/device_bridge/testing/toy_world.hpp"

namespace device_bridge {
namespace {

ToyWorld Pressing(double wall_N_per_m = 5000.0) {
  ToyWorld world("step a\nwait 1.2\npush 0 0 -1 by 0.05 speed 0.05\nwait 100\n");
  world.contact = [wall_N_per_m](const core::DeviceState& state) {
    const double depth_m = -0.02 - state.X_WD.translation.z;
    if (depth_m <= 0.0) return core::Wrench{};
    return core::Wrench{{0, 0, std::max(0.0, wall_N_per_m * depth_m - 30.0 * state.V_WD.linear_m_per_s.z)}, {0, 0, 0}};
  };
  world.Run(5.0);
  return world;
}

// The device applies the wall's full force; the hand, which pressed with more than 15 N, has relaxed and rests on it.
void ExpectForceIsBack(ToyWorld* world) {
  world->Run(1.0);
  EXPECT_GT(world->outputs.applied[0].force_N.z, 3.0);
  EXPECT_NEAR(world->outputs.applied[0].force_N.z, world->command.F_Do_W.force_N.z, 0.1);
}

TEST(DeviceBridge, ForceIsZeroWithin60MsAfterTheLastCommandAndTheHandStaysSlow) {
  ToyWorld world = Pressing();
  ASSERT_GT(world.outputs.applied[0].force_N.z, 15.0);
  world.is_linked = false;
  const std::int64_t last_ns = world.received_ns;
  double fastest = 0.0;
  double before_N = world.outputs.applied[0].force_N.z;
  for (int i = 0; i < 300; ++i) {
    world.Tick();
    const double force_N = glm::length(world.outputs.applied[0].force_N);
    if (world.now_ns - last_ns > 12'000'000) {
      EXPECT_LE(force_N, before_N + 1e-9);
    }
    if (world.now_ns - last_ns >= 60'000'000) {
      EXPECT_EQ(force_N, 0.0) << i;
    }
    before_N = std::max(force_N, 1e-12);
    fastest = std::max(fastest, glm::length(world.outputs.states[0].V_WD.linear_m_per_s));
  }
  EXPECT_TRUE(world.outputs.filter_status[0] & kSilent);
  EXPECT_LT(fastest, 0.30);
  EXPECT_EQ(world.bridge->figures(0).link_losses, 1U);
  EXPECT_LT(world.bridge->figures(0).oldest_force_ms, 60.0);
  EXPECT_GT(world.bridge->figures(0).oldest_force_ms, 40.0) << "it fades, it is not cut";
  EXPECT_NE(world.bridge->figures(0).first_cause & kDegraded, 0U);
}

TEST(DeviceBridge, ForceIsZeroWithin60MsAfterPhysicsNodeEnded) {
  ToyWorld world = Pressing();
  ASSERT_GT(world.outputs.applied[0].force_N.z, 15.0);
  world.has_physics = false;  // the haptic node goes on sending
  const std::int64_t last_ns = world.now_ns;
  for (int i = 0; i < 100; ++i) {
    world.Tick();
    if (world.now_ns - last_ns >= 60'000'000) {
      EXPECT_EQ(glm::length(world.outputs.applied[0].force_N), 0.0) << i;
    }
  }
  world.has_physics = true;
  ExpectForceIsBack(&world);
}

TEST(DeviceBridge, ForceReturnsWithARampWhenCommandsResume) {
  ToyWorld world = Pressing();
  world.is_linked = false;
  world.Run(0.2);
  world.is_linked = true;
  world.command.header.sequence = 0;  // a new process counts from 1
  world.Tick();
  world.Tick();
  EXPECT_LT(world.outputs.applied[0].force_N.z, 3.0);
  ExpectForceIsBack(&world);
}

TEST(DeviceBridge, TheForceLimitIsTheSmallerOfDeviceLimitAndCap) {
  ToyWorld world("step a\nwait 100\n", 1, [](scene::Scenario& scenario) {
    scenario.devices[0].max_force_N = 50.0;
    scenario.force_cap_N = 12.0;
  });
  world.contact = [](const core::DeviceState&) { return core::Wrench{{0, 30, 40}, {0, 0, 0}}; };
  world.Run(1.5);
  const RoleFigures figures = world.bridge->figures(0);
  EXPECT_NEAR(figures.peak_force_N, 12.0, 1e-9);
  EXPECT_LE(figures.peak_force_N, 12.0);
  EXPECT_EQ(figures.samples_over_limit, 0U);
  EXPECT_GT(figures.status_samples[4], 0U);  // kForceLimited
}

TEST(DeviceBridge, EverySampleCarriesItsTraceAndTheEchoLogMeasuresTheLoop) {
  ToyWorld world("step a\nwait 100\n");
  world.Run(0.5);
  const core::Header& header = world.outputs.states[0].header;
  EXPECT_EQ(header.direct.id, core::MakeTraceId(0, header.sequence));
  EXPECT_EQ(header.direct.origin_ns, world.now_ns);
  EXPECT_EQ(header.direct.stamps[0].stage, core::Stage::kDeviceSample);
  EXPECT_FALSE(header.through_physics.valid());
  const LatencySummary direct = world.bridge->echo_log().Summary(EchoLog::Chain::kDirect);
  EXPECT_EQ(direct.n, 499U);  // the last sample is still under way
  EXPECT_DOUBLE_EQ(direct.mean_ms, 1.0);
  EXPECT_EQ(world.bridge->echo_log().Summary(EchoLog::Chain::kThroughPhysics).n, 0U);
}

TEST(DeviceBridge, ACommandBetweenTicksReachesTheDeviceAtOnce) {
  ToyWorld world("step a\nwait 100\n");
  world.Run(1.5);
  core::DeviceCommand command = world.command;
  command.header.sequence += 1;
  command.header.direct.Add(core::Stage::kHapticSend, world.now_ns + 100'000);
  command.F_Do_W.force_N = {5, 0, 0};
  const RoleFigures before = world.bridge->figures(0);
  world.bridge->AcceptCommand(0, command, world.now_ns + 300'000, world.now_ns + 310'000);
  EXPECT_EQ(world.bridge->figures(0).writes, before.writes + 1);
  EXPECT_EQ(world.bridge->figures(0).commands_accepted, before.commands_accepted + 1);
  world.bridge->AcceptCommand(0, command, world.now_ns + 300'000, world.now_ns + 310'000);
  EXPECT_EQ(world.bridge->figures(0).writes, before.writes + 1) << "the same message again is ignored";
  world.Run(0.01);
  EXPECT_GT(world.bridge->figures(0).peak_force_N, 4.0);
}

TEST(EchoLog, CountsOnlyTheFirstEchoOfAKnownSample) {
  EchoLog log(1, 100);
  core::Header header;
  for (std::uint64_t i = 1; i <= 10; ++i) log.RecordSample(0, i, static_cast<std::int64_t>(i) * 1'000'000);
  header.direct.id = core::MakeTraceId(0, 3);
  header.through_physics.id = core::MakeTraceId(0, 2);
  log.RecordWrite(header, 4'000'000);
  log.RecordWrite(header, 5'000'000);
  header.direct.id = core::MakeTraceId(0, 77);          // never sent
  header.through_physics.id = core::MakeTraceId(2, 1);  // no such role
  log.RecordWrite(header, 5'000'000);
  EXPECT_EQ(log.Summary(EchoLog::Chain::kDirect).n, 1U);
  EXPECT_DOUBLE_EQ(log.Summary(EchoLog::Chain::kDirect).mean_ms, 1.0);
  EXPECT_DOUBLE_EQ(log.Summary(EchoLog::Chain::kThroughPhysics).mean_ms, 2.0);
  EXPECT_EQ(log.num_unknown(), 2U);
}

TEST(DeviceBridge, RefusesAScriptWithErrorsAndAnUnknownDevice) {
  ToyWorld world("step a\nwait 1\n");
  scene::Scenario scenario = world.scenario;
  scenario.devices[0].type = "hologram";
  auto refused = DeviceBridge::Create(scenario, 1);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().detail.find("'hologram'"), std::string::npos);
  std::ofstream(scenario.operator_script) << "step a\nreach nowhere.spot\nflap\n";
  refused = DeviceBridge::Create(world.scenario, 1);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().detail.find(":2: "), std::string::npos) << refused.error().detail;
  EXPECT_NE(refused.error().detail.find(":3: "), std::string::npos);
}

}  // namespace
}  // namespace device_bridge
