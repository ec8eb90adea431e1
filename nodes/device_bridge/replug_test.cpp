// A device that is pulled out and put back while a bridge runs, on a virtual clock: every kind of link.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "nodes/device_bridge/testing/toy_world.hpp"
#include "nodes/device_bridge/testing/wire_peers.hpp"

namespace device_bridge {
namespace {

constexpr double kWanted_N = 5.0;
constexpr int kBack_ticks = 1000;  // a second, of the bridge's own clock
constexpr int kForceBack_ticks = 1400;

template <class P>
std::unique_ptr<WirePeer> MakePeer() {
  return std::make_unique<P>();
}
struct LinkCase {
  const char* name;
  std::unique_ptr<WirePeer> (*make)();
  bool has_connection = true;  // so that the bridge notices at once that it ends, and has to make it anew
};

// A bridge whose world pushes with 5 N all the time.
struct PluggedWorld {
  std::unique_ptr<WirePeer> peer;
  ToyWorld world;
  double most_N = 0.0;

  explicit PluggedWorld(const LinkCase& link)
      : peer(link.make()),
        world(
            "", 1, [this](scene::Scenario& scenario) { peer->Name(&scenario.devices[0]); }, Threadless()) {
    world.contact = [](const core::DeviceState& /*state*/) { return core::Wrench{{kWanted_N, 0, 0}, {}}; };
    world.after = [this](ToyWorld& w) {
      peer->Serve(w.now_ns);
      most_N = std::max({most_N, glm::length(w.outputs.applied[0].force_N), glm::length(peer->told().F_Do_B.force_N)});
    };
  }
  static Options Threadless() {
    Options options;
    options.threads.emplace();
    options.threads->has_thread = false;
    return options;
  }
  DeviceStatus status() { return world.bridge->health(0).status; }
  // Ticks until then; -1: not within that many.
  int TicksUntil(int most, const std::function<bool()>& condition) {
    for (int i = 1; i <= most; ++i) {
      world.Tick();
      if (condition()) return i;
    }
    return -1;
  }
  bool IsPushed() const { return peer->told().F_Do_B.force_N.x > 0.99 * kWanted_N; }
};

class ReplugLink : public ::testing::TestWithParam<LinkCase> {};

// Twice, so that it comes back at different times between two tries to open it. While it is away nothing is commanded,
// and the hand stays.
TEST_P(ReplugLink, IsBackWithinASecondWithoutAForceAboveTheCommand) {
  PluggedWorld plugged(GetParam());
  ASSERT_TRUE(plugged.world.bridge);
  ASSERT_GT(plugged.TicksUntil(3000, [&] { return plugged.IsPushed(); }), 0);
  for (const double away_s : {0.5, 1.3}) {
    plugged.peer->Unplug();
    EXPECT_GT(plugged.TicksUntil(100, [&] { return plugged.status() != DeviceStatus::kAlive; }), 0);
    plugged.world.Run(away_s);
    EXPECT_NE(plugged.status(), DeviceStatus::kAlive);
    EXPECT_FALSE(plugged.world.outputs.states[0].is_engaged);
    EXPECT_EQ(glm::length(plugged.world.outputs.applied[0].force_N), 0.0);
    plugged.peer->Plug();
    EXPECT_GT(plugged.TicksUntil(kBack_ticks, [&] { return plugged.status() == DeviceStatus::kAlive; }), 0) << away_s;
    EXPECT_GT(plugged.TicksUntil(kForceBack_ticks, [&] { return plugged.IsPushed(); }), 0) << away_s;
    EXPECT_LE(plugged.most_N, kWanted_N + 1e-9);
  }
  EXPECT_EQ(plugged.world.bridge->figures(0).samples_over_limit, 0U);
}

// A shared library that says OOS_DEVICE_GONE after 0.2 s, twice, and can be opened again at once.
TEST(Replug, OfAPlugInIsBackWithinASecond) {
  ToyWorld world(
      "", 1,
      [](scene::Scenario& scenario) {
        scenario.devices[0].type = "plugin";
        scenario.devices[0].address = VR_OOS_BINARY_DIR "/test_plugins/faulty_device.so";
        scenario.devices[0].options = {{"fault", "unplugged on a virtual clock"}};
      },
      PluggedWorld::Threadless());
  ASSERT_TRUE(world.bridge);
  int away_ticks = 0, longest_ticks = 0;
  world.after = [&](ToyWorld& w) {
    const bool is_there = w.bridge->health(0).status == DeviceStatus::kAlive;
    away_ticks = is_there ? 0 : away_ticks + 1;
    longest_ticks = std::max(longest_ticks, away_ticks);
  };
  world.Run(3.0);
  EXPECT_EQ(world.bridge->device(0).num_found(), 3U);
  EXPECT_EQ(away_ticks, 0);
  EXPECT_GT(longest_ticks, 100);
  EXPECT_LE(longest_ticks, kBack_ticks);
}

// HUG's own fault of that name. Its state is back at once; its force needs a second of good link and one of engaging.
TEST(Replug, OfHugIsBackWithinASecondAndItsForceTwoLater) {
  ToyWorld world("", 1, [](scene::Scenario& scenario) {
    scenario.devices[0].type = "hug";
    scenario.devices[0].options.emplace_back("faults", "unplug at 4 for 0.5");
  });
  ASSERT_TRUE(world.bridge);
  world.contact = [](const core::DeviceState& /*state*/) { return core::Wrench{{kWanted_N, 0, 0}, {}}; };
  world.Run(3.9);
  const auto Status = [&] { return world.bridge->health(0).status; };
  const auto Felt_N = [&] { return glm::length(world.bridge->device(0).Felt().F_Do_W.force_N); };
  EXPECT_NEAR(Felt_N(), kWanted_N, 1e-6);
  world.Run(0.4);
  EXPECT_NE(Status(), DeviceStatus::kAlive);
  EXPECT_EQ(Felt_N(), 0.0);
  world.Run(0.2 + 1.0);
  EXPECT_EQ(Status(), DeviceStatus::kAlive);
  world.Run(2.0);
  EXPECT_NEAR(Felt_N(), kWanted_N, 0.5);  // with what keeps it passive
}

// What the bridge says of itself is what is counted here. A sample is sent after a tick and read in the next; where the
// bridge has to open the device, it counts from its last try in vain, which was before the device was put back.
TEST_P(ReplugLink, IsNoticedAsSoonAsTheBridgeSays) {
  PluggedWorld plugged(GetParam());
  ASSERT_TRUE(plugged.world.bridge);
  const Presence& presence = plugged.world.bridge->presence(0);
  ASSERT_GT(plugged.TicksUntil(3000, [&] { return plugged.IsPushed(); }), 0);
  EXPECT_EQ(presence.num_losses(), 0U);
  for (const double away_s : {0.5, 1.3}) {
    plugged.peer->Unplug();
    const int lost_ticks = plugged.TicksUntil(100, [&] { return plugged.status() != DeviceStatus::kAlive; });
    EXPECT_EQ(presence.steps_to_lost(), GetParam().has_connection ? lost_ticks : lost_ticks - 1);
    plugged.world.Run(away_s);
    plugged.peer->Plug();
    const int found_ticks = plugged.TicksUntil(kBack_ticks, [&] { return plugged.status() == DeviceStatus::kAlive; });
    if (GetParam().has_connection) {
      EXPECT_GE(presence.steps_to_found(), found_ticks);
      EXPECT_LE(presence.steps_to_found(), found_ticks + 250) << "between two tries";
    } else {
      EXPECT_EQ(presence.steps_to_found(), found_ticks - 1);
    }
  }
  EXPECT_EQ(presence.num_losses(), 2U);
  EXPECT_LE(std::max(presence.most_steps_to_lost(), presence.most_steps_to_found()), kBack_ticks);
}

INSTANTIATE_TEST_SUITE_P(Each, ReplugLink,
                         ::testing::Values(LinkCase{"udp", MakePeer<UdpPeer>, false},
                                           LinkCase{"serial", MakePeer<SerialPeer>},
                                           LinkCase{"haply", MakePeer<HaplyPeer>}),
                         [](const auto& link) { return link.param.name; });

}  // namespace
}  // namespace device_bridge
