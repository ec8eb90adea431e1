// LATEST without unicast datagrams: by ZeroMQ where the network blocks datagrams, and by a multicast group.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "bus/security/keys.hpp"
#include "bus/testing/make_node.hpp"
#include "bus/testing/own_network.hpp"

namespace bus {
namespace {

using testing::ExpectAccountsClose;
using testing::kLong_ns;
using testing::OwnNetwork;
using testing::Until;
using testing::WaitBriefly;

constexpr const char* kGroup = "239.255.74.50:7450";

class LatestWays : public ::testing::TestWithParam<bool> {
 protected:
  // Encrypted if the parameter is true.
  LatestWays() {
    if (GetParam()) {
      EXPECT_TRUE(MakeKeys(folder_, {"physics_node", "haptic_node", "visual_node", "logic_node"}).has_value());
    }
  }
  ~LatestWays() override { std::filesystem::remove_all(folder_); }

  std::unique_ptr<Registry> MakeRegistry() const {
    RegistryOptions options;
    options.session = 7;
    options.is_encrypted = GetParam();
    if (GetParam()) options.keys = folder_.string();
    return std::move(*Registry::Create(options));
  }
  std::unique_ptr<Node> MakeNode(NodeOptions options, const Registry& registry) const {
    options.registry = registry.endpoint();
    options.session = 7;
    options.is_encrypted = GetParam();
    if (GetParam()) options.keys = folder_.string();
    auto node = Node::Create(options);
    EXPECT_TRUE(node.has_value()) << node.error().detail;
    return std::move(*node);
  }
  static std::uint64_t Refused(const Node& node) { return node.counters().refused; }

 private:
  std::filesystem::path folder_ =
      std::filesystem::path(::testing::TempDir()) / ("latest_ways" + std::to_string(::getpid()));
};

unsigned PortOf(const Node& of, const std::string& peer) {
  for (const PeerStatus& status : of.Peers()) {
    if (status.name == peer)
      return static_cast<unsigned>(std::stoul(status.udp_endpoint.substr(status.udp_endpoint.rfind(':') + 1)));
  }
  return 0;
}

TEST_P(LatestWays, ATcpTopicArrivesWhereItsDatagramsAreBlocked) {
  const std::string why = OwnNetwork::Run([this](OwnNetwork& network) {
    const auto registry = MakeRegistry();
    auto writer = MakeNode({.name = "physics_node", .registry = {}, .tcp_topics = {"physics/s*"}}, *registry);
    auto reader = MakeNode({.name = "haptic_node", .registry = {}}, *registry);
    auto detoured = writer->WriteLatest<core::PhysicsState>(kPhysicsStateTopic);
    auto direct = writer->WriteLatest<core::Reaction>(ReactionTopic("right"));
    auto& detoured_reader = reader->ReadLatest<core::PhysicsState>(kPhysicsStateTopic);
    auto& direct_reader = reader->ReadLatest<core::Reaction>(ReactionTopic("right"));
    ASSERT_TRUE(writer->Start());
    ASSERT_TRUE(reader->Start());
    ASSERT_TRUE(reader->WaitForPeers({"physics_node"}, kLong_ns));
    ASSERT_TRUE(network.DropDatagramsFrom(PortOf(*reader, "physics_node")));
    ASSERT_TRUE(Until([&] { return writer->Poll(), detoured.has_subscribers() && direct.has_subscribers(); }));
    core::PhysicsState state;
    state.bodies.resize(60);  // several datagrams
    core::Reaction reaction;
    // What is sent before the reader's connection stands is lost, as LATEST may be.
    ASSERT_TRUE(Until([&] { return detoured.Send(state), WaitBriefly(*reader), detoured_reader.has_value(); }));
    for (state.tick = 1; state.tick <= 100; ++state.tick) {
      detoured.Send(state);
      direct.Send(reaction);
      EXPECT_TRUE(Until([&] {
        WaitBriefly(*reader);
        return detoured_reader.has_value() && detoured_reader.value().tick == state.tick;
      }));
      EXPECT_EQ(detoured_reader.value().bodies.size(), 60U);
    }
    EXPECT_FALSE(direct_reader.has_value());
    ExpectAccountsClose({writer.get(), reader.get()});
    for (const Account& account : reader->Accounts()) {
      if (account.topic == kPhysicsStateTopic) {
        EXPECT_GT(account.received, 100U);
      }
      if (account.topic == ReactionTopic("right")) {
        EXPECT_EQ(account.dropped_for(DropReason::kLost), 100U);
      }
    }
  });
  if (!why.empty()) GTEST_SKIP() << why;
}

TEST_P(LatestWays, AGroupGetsOneDatagramAndOtherReadersUnicast) {
  const std::string why = OwnNetwork::Run([this](OwnNetwork&) {
    const auto registry = MakeRegistry();
    auto writer = MakeNode({.name = "physics_node", .registry = {}, .multicast = kGroup}, *registry);
    std::vector<std::unique_ptr<Node>> readers;
    std::vector<LatestReader<core::PhysicsState>*> values;
    readers.push_back(MakeNode({.name = "haptic_node", .registry = {}, .multicast = kGroup}, *registry));
    readers.push_back(MakeNode({.name = "visual_node", .registry = {}, .multicast = kGroup}, *registry));
    readers.push_back(MakeNode({.name = "logic_node", .registry = {}}, *registry));
    auto states = writer->WriteLatest<core::PhysicsState>(kPhysicsStateTopic);
    auto reactions = writer->WriteLatest<core::Reaction>(ReactionTopic("right"));
    for (const auto& reader : readers) values.push_back(&reader->ReadLatest<core::PhysicsState>(kPhysicsStateTopic));
    readers[0]->ReadLatest<core::Reaction>(ReactionTopic("right"));  // the others of the group get it, too
    ASSERT_TRUE(writer->Start());
    for (const auto& reader : readers) ASSERT_TRUE(reader->Start());
    for (const auto& reader : readers) ASSERT_TRUE(reader->WaitForPeers({"physics_node"}, kLong_ns));
    ASSERT_TRUE(writer->WaitForPeers({"haptic_node", "visual_node", "logic_node"}, kLong_ns));
    core::PhysicsState state;
    state.tick = 1;
    ASSERT_TRUE(Until([&] { return states.Send(state) == 2; }));  // the group, and logic_node
    std::vector<std::uint64_t> refused;
    for (const auto& reader : readers) {
      reader->Poll();
      refused.push_back(Refused(*reader));
    }
    writer->Poll();
    const std::uint64_t refused_by_writer = Refused(*writer);  // from senders that were not known yet
    core::Reaction reaction;
    for (state.tick = 1; state.tick <= 100; ++state.tick) {
      EXPECT_EQ(states.Send(state), 2);
      EXPECT_EQ(reactions.Send(reaction), 1);
      for (std::size_t i = 0; i < readers.size(); ++i) {
        EXPECT_TRUE(Until([&] {
          WaitBriefly(*readers[i]);
          return values[i]->has_value() && values[i]->value().tick == state.tick;
        })) << readers[i]->name();
      }
    }
    writer->Poll();  // its own have come back
    EXPECT_EQ(Refused(*writer), refused_by_writer);
    for (std::size_t i = 0; i < readers.size(); ++i) EXPECT_EQ(Refused(*readers[i]), refused[i]) << readers[i]->name();
    ExpectAccountsClose({writer.get(), readers[0].get(), readers[1].get(), readers[2].get()});
  });
  if (!why.empty()) GTEST_SKIP() << why;
}

INSTANTIATE_TEST_SUITE_P(Keys, LatestWays, ::testing::Bool(),
                         [](const auto& keys) { return keys.param ? "Encrypted" : "InTheClear"; });

TEST(Multicast, AnythingButAGroupIsRefusedByName) {
  for (const char* group : {"10.0.0.1:7450", "239.255.74.50", "239.255.74.50:0", "group"}) {
    NodeOptions options;
    options.name = "physics_node";
    options.registry = "tcp://127.0.0.1:1";
    options.is_encrypted = false;
    options.multicast = group;
    const auto node = Node::Create(options);
    ASSERT_FALSE(node.has_value()) << group;
    EXPECT_NE(node.error().detail.find(group), std::string::npos) << node.error().detail;
  }
}

}  // namespace
}  // namespace bus
