#include "nodes/device_bridge/tactile/tactiles.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "bus/membership/registry.hpp"
#include "bus/topics.hpp"
#include "core/clock.hpp"
#include "nodes/device_bridge/devices/make_device.hpp"
#include "nodes/device_bridge/node_loop.hpp"

namespace device_bridge {
namespace {

constexpr std::uint64_t kTactileSession = 4712;

scene::Scenario BallOnPlate() {
  scene::Scenario scenario;
  scenario.name = "tactile";
  scenario.duration_limit_s = 10.0;
  scenario.devices.resize(1);
  scenario.devices[0].role = "right";
  scenario.objects.resize(2);
  scenario.objects[0].name = "ball";
  scenario.objects[0].owner = scene::Owner::kHand;
  scenario.objects[0].part = scene::HandPart::kPalm;
  scenario.objects[0].role = 0;
  scenario.objects[1].name = "plate";
  scenario.devices[0].palm = 0;
  scene::Pair pair;
  pair.sampled = 0;
  pair.field = 1;
  scenario.pairs.push_back(pair);
  scene::Tactile tactile;
  tactile.name = "bracelet";
  tactile.body = 0;
  tactile.device_file = VR_OOS_SOURCE_DIR "/scenarios/touch/vibrotac.xml";
  scenario.tactiles.push_back(tactile);
  return scenario;
}

bus::NodeOptions TactileNode(const std::string& name, const bus::Registry& registry) {
  bus::NodeOptions options;
  options.name = name;
  options.registry = registry.endpoint();
  options.session = kTactileSession;
  options.is_encrypted = false;
  return options;
}

// The ball is 3 mm in a plate at its side x, where motor 0 is.
core::ContactSet SideContact() {
  core::ContactSet set;
  set.sampled_body = 0;
  set.field_body = 1;
  set.is_in_contact = true;
  core::ContactPlane plane;
  plane.n_G = {-1.0f, 0.0f, 0.0f};
  plane.p_S = {0.003f, 0.0f, 0.0f};
  plane.stiffness_N_per_m = 1000.0f;
  set.planes.push_back(plane);
  return set;
}

// From the contacts of haptic_node on the bus to the simulated device's thread and its state on the bus, and off again.
TEST(Tactiles, AContactOnTheBusIsAStateOnTheBusUntilContactsStop) {
  scene::Scenario scenario = BallOnPlate();
  scenario.tactiles.push_back(scenario.tactiles[0]);
  scenario.tactiles[1].name = "fingertip";
  scenario.tactiles[1].device_file = VR_OOS_SOURCE_DIR "/scenarios/touch/fingertip.xml";
  auto registry = bus::Registry::Create({"tcp://127.0.0.1:0", kTactileSession, "", false});
  ASSERT_TRUE(registry) << registry.error().detail;
  Options options;
  options.clock = core::MonotonicNow_ns;
  auto bridge = DeviceBridge::Create(scenario, 1, options);
  ASSERT_TRUE(bridge) << bridge.error().detail;
  auto bridge_node = bus::Node::Create(TactileNode("device_bridge", **registry));
  ASSERT_TRUE(bridge_node) << bridge_node.error().detail;
  auto tactiles = Tactiles::Create(scenario);
  ASSERT_TRUE(tactiles) << tactiles.error().detail;
  NodeLoop loop(scenario, {}, std::move(*tactiles), bridge->get(), bridge_node->get());
  loop.Declare();
  ASSERT_TRUE((*bridge_node)->Start());
  auto source = bus::Node::Create(TactileNode("haptic_node", **registry));
  ASSERT_TRUE(source) << source.error().detail;
  auto contacts = (*source)->WriteLatest<core::ContactSet>(bus::ContactsTopic("haptic_node", scenario.PairName(0)));
  auto proxies = (*source)->WriteLatest<core::HapticProxy>(bus::HapticProxyTopic("right"));
  const auto& states = (*source)->ReadLatest<core::TactileState>(bus::TactileStateTopic("bracelet"));
  const auto& fingertip = (*source)->ReadLatest<core::TactileState>(bus::TactileStateTopic("fingertip"));
  core::HapticProxy proxy;
  ASSERT_TRUE((*source)->Start());

  std::atomic<bool> stop{false};
  std::thread thread([&] { loop.Run(stop); });
  const auto wait_for = [&](bool is_sending, const auto& is_reached) {
    core::ContactSet set = SideContact();
    const std::int64_t begin_ns = core::MonotonicNow_ns();
    while (core::MonotonicNow_ns() - begin_ns < 30'000'000'000) {
      if (is_sending) contacts.Send(set);
      proxies.Send(proxy);
      (*source)->Wait(core::MonotonicNow_ns() + 1'000'000);
      if (states.has_value() && is_reached(states.value())) return true;
    }
    return false;
  };
  EXPECT_TRUE(wait_for(true, [](const core::TactileState& state) {
    return state.status == 1 && state.channels.size() == 6 && state.channels[0].level > 0.99f;
  }));
  const core::TactileState touching = states.value();
  EXPECT_TRUE(touching.is_simulated);
  EXPECT_NEAR(touching.depth_m, 0.003, 1e-6);
  EXPECT_NEAR(touching.force_N, 3.0, 1e-3);
  EXPECT_NEAR(touching.towards_B.x, 1.0, 1e-6);
  // A second in contact, and no current while the dead-man is not held.
  const std::int64_t touched_ns = core::MonotonicNow_ns();
  EXPECT_TRUE(wait_for(true, [&](const auto&) { return core::MonotonicNow_ns() - touched_ns > 1'000'000'000; }));
  ASSERT_TRUE(fingertip.has_value());
  EXPECT_EQ(fingertip.value().frames, 0u);
  proxy.is_engaged = true;
  EXPECT_TRUE(wait_for(true, [&](const auto&) { return fingertip.value().frames > 3; }));
  EXPECT_TRUE(wait_for(
      false, [](const core::TactileState& state) { return state.depth_m == 0.0 && state.channels[0].level == 0.0f; }));
  stop.store(true);
  thread.join();
}

// Electrodes give current only while the person holds the dead-man of the hand, whatever it touches.
TEST(Tactiles, ElectrodesWaitForTheDeadMan) {
  scene::Scenario scenario = BallOnPlate();
  scenario.tactiles[0].device_file = VR_OOS_SOURCE_DIR "/scenarios/touch/fingertip.xml";
  scenario.tactiles[0].full_force_N = 1.0;
  const auto device = MakeWornDevice(scenario.tactiles[0]);
  ASSERT_TRUE(device) << device.error().detail;
  EXPECT_TRUE((*device)->is_simulated());
  const core::ContactSet set = SideContact();
  const BodyPoses poses(scenario);
  BodyTouch touch(scenario, scenario.tactiles[0]);
  core::TactileState state;
  state.channels.resize((*device)->num_channels());
  // Calls as the bridge's, until so many pulses were given, or for so long.
  const auto run = [&](bool is_engaged, std::uint64_t pulses, std::int64_t most_ns) {
    const std::int64_t begin_ns = core::MonotonicNow_ns();
    do {
      const std::int64_t now_ns = core::MonotonicNow_ns();
      const SeenContacts seen[] = {{&set, now_ns}};
      touch.Step(now_ns, seen, poses);
      (*device)->Feel(now_ns, touch, is_engaged);
      (*device)->Fill(&state);
      std::this_thread::yield();
    } while (state.frames < pulses && core::MonotonicNow_ns() - begin_ns < most_ns);
    return state.frames;
  };
  EXPECT_EQ(run(false, 1, 300'000'000), 0u);
  EXPECT_GE(run(true, 5, 30'000'000'000), 5u);
  EXPECT_NE(state.pattern, 0) << "a touch, or pressure already";
}

TEST(Tactiles, NoRealElectrodesAreDriven) {
  scene::Scenario scenario = BallOnPlate();
  scenario.tactiles[0].device_file = VR_OOS_SOURCE_DIR "/scenarios/touch/fingertip.xml";
  scenario.tactiles[0].type = "usb";
  EXPECT_FALSE(MakeWornDevice(scenario.tactiles[0]));
}

TEST(Tactiles, AFileThatIsWrongIsToldBeforeTheRun) {
  scene::Scenario scenario = BallOnPlate();
  EXPECT_TRUE(CheckTactiles(scenario).empty());
  scenario.tactiles[0].device_file = VR_OOS_SOURCE_DIR "/scenarios/touch/scenario.xml";
  EXPECT_FALSE(CheckTactiles(scenario).empty());
  EXPECT_FALSE(Tactiles::Create(scenario));
}

TEST(Tactiles, TheCommandLineChoosesTheRealDevice) {
  scene::Scenario scenario = BallOnPlate();
  ASSERT_TRUE(ChooseDevices({"bracelet=usb"}, &scenario));
  EXPECT_EQ(scenario.tactiles[0].type, "usb");
  const auto wrong = ChooseDevices({"bracelet=udp:7460"}, &scenario);
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().detail.find("simulated or usb"), std::string::npos);
}

}  // namespace
}  // namespace device_bridge
