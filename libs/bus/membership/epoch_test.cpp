// Names and written topics have one holder; its successor fences it off.

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <zmq.hpp>

#include "bus/reliable/routed.hpp"
#include "bus/testing/make_node.hpp"
#include "bus/wire/control.hpp"
#include "proto/bus.pb.h"

namespace bus {
namespace {

using testing::ExpectAccountsClose;
using testing::kLong_ns;
using testing::MakeNode;
using testing::MakeRegistry;
using testing::Until;
using testing::WaitBriefly;

std::unique_ptr<Node> MakeSuccessor(const std::string& name, const std::string& registry) {
  NodeOptions options;
  options.name = name;
  options.registry = registry;
  options.session = 7;
  options.is_encrypted = false;
  options.takes_over = true;
  return std::move(*Node::Create(options));
}

bool FindEvent(Node& node, const std::string& name) {
  core::Event event;
  while (node.PollEvent(&event)) {
    if (event.name == name) return true;
  }
  return false;
}

std::uint64_t CountFenced(const Node& node) {
  for (const RefusalCount& refusal : node.counters().refusals) {
    if (refusal.reason == "fenced") return refusal.count;
  }
  return 0;
}

TEST(Epoch, AnExplicitTakeoverFencesTheLivingHolderOff) {
  const auto registry = MakeRegistry();
  auto watcher = MakeNode("logic_node", registry->endpoint());
  watcher->OwnParameters({"cap"});
  auto& reader = watcher->ReadLatest<core::PhysicsState>(kPhysicsStateTopic);
  auto first = MakeNode("physics_a", registry->endpoint());
  auto first_writer = first->WriteLatest<core::PhysicsState>(kPhysicsStateTopic);
  ASSERT_TRUE(watcher->Start().has_value());
  ASSERT_TRUE(first->Start().has_value());
  ASSERT_TRUE(Until([&] { return first_writer.has_subscribers(); }));

  auto second = MakeSuccessor("physics_b", registry->endpoint());
  auto second_writer = second->WriteLatest<core::PhysicsState>(kPhysicsStateTopic);
  const auto started = second->Start(kLong_ns);
  ASSERT_TRUE(started.has_value()) << started.error().detail;
  EXPECT_EQ(registry->Names(), (std::vector<std::string>{"logic_node", "physics_b"}));
  EXPECT_TRUE(Until([&] {
    WaitBriefly(*watcher);
    return FindEvent(*watcher, "node_fenced");
  }));

  // It is notified, and stops sending.
  EXPECT_TRUE(Until([&] {
    WaitBriefly(*first);
    return FindEvent(*first, "fenced");
  }));
  EXPECT_TRUE(Until([&] { return !first_writer.has_subscribers(); }));
  // Its requests are refused and counted.
  EXPECT_NE(first->PostParameter("logic_node", {"cap", 1.0}), 0u);
  EXPECT_TRUE(Until([&] { return CountFenced(*watcher) > 0; }));
  core::ParameterChange change;
  std::uint64_t ticket = 0;
  EXPECT_FALSE(watcher->PollParameter(&change, &ticket));

  ASSERT_TRUE(Until([&] { return second_writer.has_subscribers(); }));
  core::PhysicsState state;
  state.tick = 2;
  second_writer.Send(state);
  EXPECT_TRUE(Until([&] {
    WaitBriefly(*watcher);
    return reader.value().tick == 2;
  }));
  ExpectAccountsClose({watcher.get(), second.get()});
}

TEST(Epoch, AFencedInstanceStaysOutAndANewOneOfItsNameMayJoin) {
  const auto registry = MakeRegistry();
  auto first = MakeNode("physics_node", registry->endpoint());
  ASSERT_TRUE(first->Start().has_value());
  auto second = MakeSuccessor("physics_node", registry->endpoint());
  ASSERT_TRUE(second->Start(kLong_ns).has_value());
  EXPECT_TRUE(Until([&] {
    WaitBriefly(*first);
    return FindEvent(*first, "fenced");
  }));
  second.reset();
  auto third = MakeNode("physics_node", registry->endpoint());
  EXPECT_TRUE(third->Start(kLong_ns).has_value());
  ExpectAccountsClose({third.get()});
}

std::vector<std::uint8_t> Encoded(const std::string& sender, const oos::Control& control) {
  return detail::EncodeControl({7, TopicId(sender), 1}, TopicClass::kControl, control);
}

// Speaks for the registry, so that a roster can come later than a subscription of a node that it names.
class ScriptedRegistry {
 public:
  explicit ScriptedRegistry(zmq::context_t* context) : router_(*context, zmq::socket_type::router) {
    router_.set(zmq::sockopt::linger, 0);
    router_.bind("tcp://127.0.0.1:*");
  }
  std::string endpoint() const { return router_.get(zmq::sockopt::last_endpoint); }
  // Answers one HELLO with a roster that has no nodes; null: there is none.
  std::optional<oos::NodeRecord> Answer(const std::vector<std::uint64_t>& fenced) {
    zmq::message_t routing, message;
    oos::Control hello;
    if (!detail::ReceiveRouted(&router_, &routing, &message)) return std::nullopt;
    if (!detail::DecodeControl({message.data<std::uint8_t>(), message.size()}, 7, &hello)) return std::nullopt;
    oos::Control answer;
    answer.mutable_roster()->set_version(1 + fenced.size());
    answer.mutable_roster()->set_boot(1);
    for (const std::uint64_t instance : fenced) answer.mutable_roster()->add_fenced(instance);
    router_.send(routing, zmq::send_flags::sndmore);
    router_.send(zmq::buffer(Encoded("registry", answer)), zmq::send_flags::none);
    return hello.hello().node();
  }

 private:
  zmq::socket_t router_;
};

TEST(Epoch, AFencedReaderThatNoRosterNamedLeavesNoAccountOpen) {
  zmq::context_t context;
  ScriptedRegistry registry(&context);
  NodeOptions options;
  options.name = "physics_node";
  options.registry = registry.endpoint();
  options.session = 7;
  options.is_encrypted = false;
  auto node = std::move(*Node::Create(options));
  ASSERT_TRUE(node->Start(0).has_value());
  std::optional<oos::NodeRecord> record;
  ASSERT_TRUE(Until([&] { return (record = registry.Answer({})).has_value(); }));

  constexpr std::uint64_t kReader = 4711;
  zmq::socket_t reader(context, zmq::socket_type::dealer);
  reader.set(zmq::sockopt::linger, 0);
  reader.set(zmq::sockopt::routing_id, "logic_node#" + std::to_string(kReader));
  reader.connect(record->router_endpoint());
  oos::Control subscription;
  subscription.mutable_subscribe()->set_name("logic_node");
  subscription.mutable_subscribe()->set_instance(kReader);
  subscription.mutable_subscribe()->set_wants_events(true);
  reader.send(zmq::buffer(Encoded("logic_node", subscription)), zmq::send_flags::none);
  ASSERT_TRUE(Until([&] { return !node->Accounts().empty(); }));
  ASSERT_TRUE(node->Emit({0, "", "never_acknowledged", ""}));
  ASSERT_TRUE(Until([&] {
    WaitBriefly(*node);
    return node->Accounts().front().sent == 1;
  }));
  EXPECT_FALSE(node->Accounts().front().is_settled());

  ASSERT_TRUE(Until([&] {
    registry.Answer({kReader});
    return node->Accounts().front().is_settled();
  }));
}

#if !defined(__SANITIZE_THREAD__)
// A suspended process is replaced, and then resumed. With `restarts` the registry, too, was replaced meanwhile and does
// not know it.
void ReplaceAZombie(bool restarts) {
  // The child must not inherit the registry's socket: its port would stay taken.
  const std::string endpoint = MakeRegistry()->endpoint();
  constexpr int kWasFenced = 42;
  const pid_t zombie = fork();
  ASSERT_GE(zombie, 0);
  if (zombie == 0) {
    auto node = MakeNode("physics_node", endpoint);
    auto writer = node->WriteLatest<core::PhysicsState>(kPhysicsStateTopic);
    if (!node->Start()) _exit(1);
    core::PhysicsState state;
    state.tick = 1;
    for (;;) {
      writer.Send(state);
      WaitBriefly(*node);
      if (FindEvent(*node, "fenced")) _exit(kWasFenced);
    }
  }
  auto registry = MakeRegistry(endpoint);
  auto watcher = MakeNode("logic_node", endpoint);
  auto& reader = watcher->ReadLatest<core::PhysicsState>(kPhysicsStateTopic);
  const auto watching = watcher->Start();
  const bool is_heard = Until([&] {
    WaitBriefly(*watcher);
    return reader.value().tick == 1;
  });
  kill(zombie, SIGSTOP);
  if (restarts) {
    registry.reset();
    registry = MakeRegistry(endpoint);
  }
  auto successor = MakeNode("physics_node", endpoint);
  auto writer = successor->WriteLatest<core::PhysicsState>(kPhysicsStateTopic);
  const auto started = successor->Start(kLong_ns);
  core::PhysicsState state;
  state.tick = 2;
  const bool is_replaced = Until([&] {
    writer.Send(state);
    WaitBriefly(*watcher);
    return reader.value().tick == 2;
  });
  kill(zombie, SIGCONT);
  int status = 0;
  bool is_old_shown = false;
  const bool is_notified = Until([&] {
    WaitBriefly(*watcher);
    is_old_shown = is_old_shown || reader.value().tick == 1;
    return waitpid(zombie, &status, WNOHANG) == zombie;
  });
  if (!is_notified) {
    kill(zombie, SIGKILL);
    waitpid(zombie, nullptr, 0);
  }
  ASSERT_TRUE(watching.has_value());
  ASSERT_TRUE(is_heard);
  ASSERT_TRUE(started.has_value()) << started.error().detail;
  EXPECT_TRUE(is_replaced);
  EXPECT_FALSE(is_old_shown);
  EXPECT_TRUE(is_notified && WIFEXITED(status) && WEXITSTATUS(status) == kWasFenced) << status;
  const std::vector<PeerStatus> peers = watcher->Peers();
  ASSERT_EQ(peers.size(), 1u);
  EXPECT_EQ(peers[0].restarts, 1u);
  ExpectAccountsClose({watcher.get(), successor.get()});
}

TEST(Epoch, AResumedZombieIsFencedOffAndNotified) {
  ReplaceAZombie(false);
}

TEST(Epoch, ANewRegistryFencesAZombieOffByItsEpoch) {
  ReplaceAZombie(true);
}
#endif

TEST(StartOrder, AllOrdersOfFiveNodesMeet) {
  std::vector<std::string> names = {"device_bridge", "haptic_node", "logic_node", "physics_node", "visual_node"};
  const auto registry = MakeRegistry();
  int orders = 0;
  do {
    std::vector<std::unique_ptr<Node>> nodes;
    for (const std::string& name : names) {
      nodes.push_back(MakeNode(name, registry->endpoint()));
      ASSERT_TRUE(nodes.back()->Start(0).has_value());
    }
    for (const auto& node : nodes) {
      std::vector<std::string> others;
      std::copy_if(names.begin(), names.end(), std::back_inserter(others),
                   [&](const std::string& name) { return name != node->name(); });
      const auto met = node->WaitForPeers(others, kLong_ns);
      ASSERT_TRUE(met.has_value()) << "order " << orders << ": " << met.error().detail;
    }
    if (orders % 20 == 0) {
      ExpectAccountsClose({nodes[0].get(), nodes[1].get(), nodes[2].get(), nodes[3].get(), nodes[4].get()});
    }
    ++orders;
  } while (std::next_permutation(names.begin(), names.end()));
  EXPECT_EQ(orders, 120);
}

}  // namespace
}  // namespace bus
