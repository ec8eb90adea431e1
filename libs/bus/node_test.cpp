#include "bus/node.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <functional>
#include <random>
#include <thread>

#include "bus/codec.hpp"
#include "bus/detail/udp_socket.hpp"
#include "bus/envelope.hpp"
#include "bus/ledger.hpp"
#include "bus/registry.hpp"
#include "bus/schema.hpp"
#include "core/clock.hpp"

namespace bus {
namespace {

constexpr std::int64_t kLong_ns = 10 * core::kNanosecondsPerSecond;

std::unique_ptr<Registry> MakeRegistry(const std::string& endpoint = "tcp://127.0.0.1:0") {
  auto registry = Registry::Create({endpoint, 7, "", false});
  EXPECT_TRUE(registry.has_value()) << registry.error().detail;
  return std::move(*registry);
}

std::unique_ptr<Node> MakeNode(const std::string& name, const std::string& registry, bool says_goodbye = true) {
  NodeOptions options;
  options.name = name;
  options.registry = registry;
  options.session = 7;
  options.is_encrypted = false;
  options.says_goodbye = says_goodbye;
  auto node = Node::Create(options);
  EXPECT_TRUE(node.has_value()) << node.error().detail;
  return std::move(*node);
}

// Calls `step` until it is true or time is up. The steps wait by themselves (Node::Wait), nothing sleeps here.
bool Until(const std::function<bool()>& step, std::int64_t timeout_ns = kLong_ns) {
  const std::int64_t deadline = core::MonotonicNow_ns() + timeout_ns;
  while (core::MonotonicNow_ns() < deadline) {
    if (step()) return true;
  }
  return step();
}

WaitResult WaitBriefly(Node& node) {
  return node.Wait(core::MonotonicNow_ns() + core::kTick_ns);
}

bool FindEvent(Node& node, const std::string& name, const std::string& detail) {
  core::Event event;
  while (node.PollEvent(&event)) {
    if (event.name == name && event.detail == detail) return true;
  }
  return false;
}

core::PhysicsState MakeState(std::uint64_t tick, std::size_t num_bodies) {
  core::PhysicsState state;
  state.tick = tick;
  for (std::size_t i = 0; i < num_bodies; ++i) {
    state.bodies.push_back({static_cast<std::uint16_t>(i), {}, {}});
    state.bodies.back().X_WO.translation.x = static_cast<double>(tick);
  }
  return state;
}

TEST(Node, LatestArrivesCompleteWithTraceAndCounts) {
  const auto registry = MakeRegistry();
  auto physics = MakeNode("physics_node", registry->endpoint());
  auto visual = MakeNode("visual_node", registry->endpoint());
  auto writer = physics->WriteLatest<core::PhysicsState>(kPhysicsStateTopic);
  auto& reader = visual->ReadLatest<core::PhysicsState>(kPhysicsStateTopic);
  ASSERT_TRUE(physics->Start().has_value());
  ASSERT_TRUE(visual->Start().has_value());
  ASSERT_TRUE(Until([&] { return writer.has_subscribers(); }));
  EXPECT_FALSE(reader.has_value());

  for (std::uint64_t tick = 1; tick <= 100; ++tick) {
    core::PhysicsState state = MakeState(tick, core::kMaxBodies);  // several datagrams
    state.header.direct.id = core::MakeTraceId(0, tick);
    state.header.direct.origin_ns = core::MonotonicNow_ns();
    state.header.direct.Add(core::Stage::kPhysicsSend, core::MonotonicNow_ns());
    EXPECT_GT(writer.Send(state), 1);
    ASSERT_TRUE(Until([&] {
      WaitBriefly(*visual);
      return reader.value().tick == tick;
    }));
    EXPECT_TRUE(reader.is_fresh());
    EXPECT_EQ(reader.value().header.direct.id, core::MakeTraceId(0, tick));
    ASSERT_EQ(reader.value().bodies.size(), core::kMaxBodies);
    for (const core::BodyState& body : reader.value().bodies) {
      ASSERT_EQ(body.X_WO.translation.x, static_cast<double>(tick));
    }
    EXPECT_LE(reader.age_ns(core::MonotonicNow_ns()), kLong_ns);
  }
  visual->Poll();
  EXPECT_FALSE(reader.is_fresh());
  EXPECT_EQ(physics->counters().sent, 100u);
  EXPECT_EQ(visual->counters().received, 100u);
  EXPECT_EQ(visual->counters().dropped, 0u);
  // The figures of the other side come with its heartbeats.
  EXPECT_TRUE(Until([&] {
    WaitBriefly(*physics);
    const auto peers = physics->Peers();
    return peers.size() == 1 && peers[0].counters.received == 100 && !peers[0].counters.topics.empty() &&
           peers[0].counters.topics[0].received == 100;
  }));
}

TEST(Node, StartsInAnyOrderAndTheRegistryLast) {
  std::string endpoint;
  endpoint = MakeRegistry()->endpoint();  // a port that is free again
  std::vector<std::unique_ptr<Node>> nodes;
  std::vector<std::thread> starters;
  for (const std::string name : {"a", "b", "c"}) nodes.push_back(MakeNode(name, endpoint));
  std::atomic<int> started{0};
  for (const auto& node : nodes) {
    starters.emplace_back([&started, raw = node.get()] {
      const auto result = raw->Start(kLong_ns);
      EXPECT_TRUE(result.has_value()) << result.error().detail;
      ++started;
    });
  }
  EXPECT_EQ(started.load(), 0);
  const auto registry = MakeRegistry(endpoint);
  for (std::thread& starter : starters) starter.join();
  for (const auto& node : nodes) {
    std::vector<std::string> others;
    for (const std::string name : {"a", "b", "c"}) {
      if (name != node->name()) others.push_back(name);
    }
    const auto met = node->WaitForPeers(others, kLong_ns);
    EXPECT_TRUE(met.has_value()) << met.error().detail;
  }
}

TEST(Node, DataFlowsOnWithoutTheRegistryAndANewOneIsFilledAgain) {
  auto registry = MakeRegistry();
  const std::string endpoint = registry->endpoint();
  auto source = MakeNode("haptic_node", endpoint);
  auto sink = MakeNode("physics_node", endpoint);
  auto writer = source->WriteLatest<core::HapticProxy>(HapticProxyTopic("right"));
  auto& reader = sink->ReadLatest<core::HapticProxy>(HapticProxyTopic("right"));
  ASSERT_TRUE(source->Start().has_value());
  ASSERT_TRUE(sink->Start().has_value());
  ASSERT_TRUE(Until([&] { return writer.has_subscribers(); }));
  registry.reset();
  core::HapticProxy proxy;
  // Longer than any time-out of the bus.
  const std::int64_t end = core::MonotonicNow_ns() + core::kNanosecondsPerSecond;
  while (core::MonotonicNow_ns() < end) {
    ++proxy.cycle;
    ASSERT_EQ(writer.Send(proxy), 1);
    ASSERT_TRUE(Until([&] {
      WaitBriefly(*sink);
      return reader.value().cycle == proxy.cycle;
    }));
  }
  registry = MakeRegistry(endpoint);
  EXPECT_TRUE(Until([&] {
    WaitBriefly(*sink);
    return registry->Names().size() == 2;
  }));
  auto late = MakeNode("visual_node", endpoint);
  ASSERT_TRUE(late->Start(kLong_ns).has_value());
  EXPECT_TRUE(late->WaitForPeers({"haptic_node", "physics_node"}, kLong_ns).has_value());
}

TEST(Node, LateJoinerGetsTheCompleteStateThenEveryChange) {
  const auto registry = MakeRegistry();
  auto logic = MakeNode("logic_node", registry->endpoint());
  auto status_writer = logic->WriteState<core::LogicStatus>(kLogicStatusTopic);
  auto figures_writer = logic->WriteState<Figures>(FiguresTopic("logic_node"));
  ASSERT_TRUE(logic->Start().has_value());
  core::LogicStatus status;
  for (const std::string step : {"cover", "switch_off", "grasp"}) {
    status.step = step;
    ASSERT_TRUE(status_writer.Set(status));
  }
  ASSERT_TRUE(figures_writer.Set({{{"one", 1.0}}}, "a"));
  ASSERT_TRUE(figures_writer.Set({{{"two", 2.0}}}, "b"));

  auto visual = MakeNode("visual_node", registry->endpoint());
  auto& status_reader = visual->ReadState<core::LogicStatus>(kLogicStatusTopic);
  auto& figures_reader = visual->ReadState<Figures>(FiguresTopic("logic_node"));
  ASSERT_TRUE(visual->Start().has_value());
  ASSERT_TRUE(Until([&] {
    WaitBriefly(*visual);
    return status_reader.value().step == "grasp" && figures_reader.values().size() == 2;
  }));
  EXPECT_EQ(*figures_reader.values().at("b").Find("two"), 2.0);
  for (int i = 0; i < 200; ++i) {
    status.step = "step " + std::to_string(i);
    ASSERT_TRUE(Until([&] { return status_writer.Set(status); }));
  }
  EXPECT_TRUE(Until([&] {
    WaitBriefly(*visual);
    return status_reader.value().step == "step 199";
  }));
}

TEST(Node, EventsArriveOnceAndInOrder) {
  const auto registry = MakeRegistry();
  auto physics = MakeNode("physics_node", registry->endpoint());
  auto logic = MakeNode("logic_node", registry->endpoint());
  logic->ReadEvents();
  ASSERT_TRUE(physics->Start().has_value());
  ASSERT_TRUE(logic->Start().has_value());
  ASSERT_TRUE(physics->WaitForPeers({"logic_node"}, kLong_ns).has_value());
  // Subscribed when the first event comes through.
  core::Event event;
  std::uint64_t first = 0;
  ASSERT_TRUE(Until([&] {
    physics->Emit({0, "physics_node", "probe", std::to_string(++first)});
    WaitBriefly(*logic);
    while (logic->PollEvent(&event)) {
      if (event.name == "probe") return true;
    }
    return false;
  }));
  // More on their way than the reader has credit for: the credit must hold up who emits, not lose events.
  constexpr int kOnTheirWay = 1500;
  int sent = 0;
  int expected = 0;
  ASSERT_TRUE(Until([&] {
    while (sent < 5000 && sent - expected < kOnTheirWay &&
           physics->Emit({sent, "physics_node", "count", std::to_string(sent)})) {
      ++sent;
    }
    WaitBriefly(*logic);
    while (logic->PollEvent(&event)) {
      if (event.name != "count") continue;
      EXPECT_EQ(event.detail, std::to_string(expected));
      EXPECT_EQ(event.source, "physics_node");
      ++expected;
    }
    return expected == 5000;
  }));
}

TEST(Node, SetParameterIsAcknowledgedWithTheTick) {
  const auto registry = MakeRegistry();
  auto owner = MakeNode("physics_node", registry->endpoint());
  auto deaf = MakeNode("visual_node", registry->endpoint());
  auto caller = MakeNode("logic_node", registry->endpoint());
  owner->OwnParameters({"latch_a.release_force_N", "shy"});
  ASSERT_TRUE(owner->Start().has_value());
  ASSERT_TRUE(deaf->Start().has_value());
  ASSERT_TRUE(caller->Start().has_value());

  std::atomic<bool> is_done{false};
  double value = 0;
  std::thread step([&] {
    std::uint64_t tick = 100;
    while (!is_done.load()) {
      WaitBriefly(*owner);
      ++tick;
      core::ParameterChange change;
      std::uint64_t ticket = 0;
      while (owner->PollParameter(&change, &ticket)) {
        const bool is_known = change.name == "latch_a.release_force_N";
        if (is_known) value = change.value;
        const bool is_ramped = change.manner == core::ChangeManner::kRamped;
        owner->AckParameter(ticket, tick, is_known, is_known ? "" : "physics_node does not want it",
                            is_ramped ? change.ramp_s : 0.25, is_ramped);
      }
    }
  });
  const auto set = caller->SetParameter("physics_node", {"latch_a.release_force_N", 12.5});
  ASSERT_TRUE(set.has_value()) << set.error().detail;
  EXPECT_GT(set->tick, 100u);
  EXPECT_EQ(set->injected_J, 0.25);
  EXPECT_FALSE(set->is_pending);
  const auto ramped =
      caller->SetParameter("physics_node", {"latch_a.release_force_N", 12.5, core::ChangeManner::kRamped, 0.75});
  ASSERT_TRUE(ramped.has_value()) << ramped.error().detail;
  EXPECT_EQ(ramped->injected_J, 0.75);
  EXPECT_TRUE(ramped->is_pending);
  const auto any = caller->SetParameter("", {"latch_a.release_force_N", 13.5});
  EXPECT_TRUE(any.has_value()) << any.error().detail;
  const auto unwanted = caller->SetParameter("physics_node", {"shy", 1});
  ASSERT_FALSE(unwanted.has_value());
  EXPECT_EQ(unwanted.error().detail, "parameter shy was not set: physics_node does not want it");
  const auto unknown = caller->SetParameter("physics_node", {"latch_a.release_froce_N", 1});
  ASSERT_FALSE(unknown.has_value());
  EXPECT_EQ(unknown.error().detail,
            "parameter latch_a.release_froce_N was not set: physics_node has no parameter 'latch_a.release_froce_N'; "
            "did you mean 'latch_a.release_force_N'? Known: 'latch_a.release_force_N' and 'shy'");
  const auto wrong = caller->SetParameter("visual_node", {"anything", 1});
  ASSERT_FALSE(wrong.has_value());
  EXPECT_NE(wrong.error().detail.find("visual_node owns no parameters"), std::string::npos) << wrong.error().detail;
  const auto nobody = caller->SetParameter("nobody", {"anything", 1}, core::kNanosecondsPerSecond / 10);
  ASSERT_FALSE(nobody.has_value());
  EXPECT_NE(nobody.error().detail.find("no live node is called nobody"), std::string::npos) << nobody.error().detail;

  const std::uint64_t request = caller->PostParameter("physics_node", {"latch_a.release_force_N", 14.5});
  ASSERT_NE(request, 0u);
  ParameterAck ack;
  EXPECT_TRUE(Until([&] {
    WaitBriefly(*caller);
    return caller->PollAck(&ack);
  }));
  EXPECT_EQ(ack.request, request);
  EXPECT_TRUE(ack.is_accepted);
  EXPECT_EQ(ack.owner, "physics_node");
  is_done.store(true);
  step.join();
  EXPECT_EQ(value, 14.5);
}

TEST(Node, RegistryRefusesWithNames) {
  const auto registry = MakeRegistry();
  auto first = MakeNode("physics_node", registry->endpoint());
  first->WriteLatest<core::PhysicsState>(kPhysicsStateTopic);
  ASSERT_TRUE(first->Start().has_value());

  auto twin = MakeNode("physics_node", registry->endpoint());
  const auto same_name = twin->Start(kLong_ns);
  ASSERT_FALSE(same_name.has_value());
  EXPECT_NE(same_name.error().detail.find("a node called physics_node"), std::string::npos) << same_name.error().detail;

  auto rival = MakeNode("rival", registry->endpoint());
  rival->WriteLatest<core::PhysicsState>(kPhysicsStateTopic);
  const auto same_topic = rival->Start(kLong_ns);
  ASSERT_FALSE(same_topic.has_value());
  EXPECT_NE(same_topic.error().detail.find("physics/state is written by physics_node already"), std::string::npos)
      << same_topic.error().detail;

  NodeOptions options;
  options.name = "stranger";
  options.registry = registry->endpoint();
  options.session = 8;
  options.is_encrypted = false;
  auto stranger = Node::Create(options);
  ASSERT_TRUE(stranger.has_value());
  const auto session = (*stranger)->Start(kLong_ns);
  ASSERT_FALSE(session.has_value());
  EXPECT_NE(session.error().detail.find("session 8"), std::string::npos) << session.error().detail;
  EXPECT_GE(registry->Refusals().size(), 3u);
}

TEST(Node, WrongDeclarationsAreToldAtStart) {
  const auto registry = MakeRegistry();
  auto node = MakeNode("confused", registry->endpoint());
  node->WriteLatest<core::Reaction>(kPhysicsStateTopic);
  node->ReadState<Figures>("no/such/topic");
  const auto started = node->Start();
  ASSERT_FALSE(started.has_value());
  EXPECT_NE(started.error().detail.find("carries oos.PhysicsState, not oos.Reaction"), std::string::npos)
      << started.error().detail;
  EXPECT_NE(started.error().detail.find("no/such/topic"), std::string::npos);
}

TEST(Node, SilentPeerIsReportedByNameWithinHalfASecondAndWelcomedBack) {
  const auto registry = MakeRegistry();
  auto watcher = MakeNode("device_bridge", registry->endpoint());
  ASSERT_TRUE(watcher->Start().has_value());
  auto victim = MakeNode("haptic_node", registry->endpoint(), false);
  ASSERT_TRUE(victim->Start().has_value());
  ASSERT_TRUE(watcher->WaitForPeers({"haptic_node"}, kLong_ns).has_value());
  ASSERT_TRUE(Until([&] { return FindEvent(*watcher, "node_found", "haptic_node"); }));

  victim.reset();  // without goodbye: sockets closed as after kill -9
  const std::int64_t died = core::MonotonicNow_ns();
  ASSERT_TRUE(Until([&] {
    WaitBriefly(*watcher);
    return FindEvent(*watcher, "node_lost", "haptic_node");
  }));
  EXPECT_LE(core::MonotonicNow_ns() - died, 500'000'000);
  EXPECT_FALSE(watcher->IsAlive("haptic_node"));

  // Started again at once: the registry must find out that the first is dead, not refuse the second.
  auto again = MakeNode("haptic_node", registry->endpoint());
  const auto started = again->Start(kLong_ns);
  ASSERT_TRUE(started.has_value()) << started.error().detail;
  ASSERT_TRUE(Until([&] {
    WaitBriefly(*watcher);
    return FindEvent(*watcher, "node_found", "haptic_node");
  }));
  const auto peers = watcher->Peers();
  ASSERT_EQ(peers.size(), 1u);
  EXPECT_EQ(peers[0].restarts, 1u);
  again.reset();  // with goodbye: no fault
  EXPECT_TRUE(Until([&] {
    WaitBriefly(*watcher);
    return FindEvent(*watcher, "node_left", "haptic_node");
  }));
}

TEST(Node, RestartedWriterIsReadFromItsFirstMessageOn) {
  const auto registry = MakeRegistry();
  auto sink = MakeNode("physics_node", registry->endpoint());
  auto& reader = sink->ReadLatest<core::HapticProxy>(HapticProxyTopic("right"));
  ASSERT_TRUE(sink->Start().has_value());
  core::HapticProxy proxy;
  for (int start = 0; start < 2; ++start) {
    auto source = MakeNode("haptic_node", registry->endpoint());
    auto writer = source->WriteLatest<core::HapticProxy>(HapticProxyTopic("right"));
    ASSERT_TRUE(source->Start(kLong_ns).has_value());
    ASSERT_TRUE(Until([&] { return writer.has_subscribers(); }));
    for (int i = 0; i < 50; ++i) writer.Send(proxy);
    proxy.cycle = 1000 + static_cast<std::uint64_t>(start);
    writer.Send(proxy);
    ASSERT_TRUE(Until([&] {
      WaitBriefly(*sink);
      return reader.value().cycle == proxy.cycle;
    }));
  }
  EXPECT_EQ(reader.restarts(), 1u);
  EXPECT_EQ(sink->counters().dropped, 0u);
}

// A node whose step thread hangs is told from one that died and one that was started again.
TEST(Node, StallIsToldFromDeath) {
  const auto registry = MakeRegistry();
  auto watcher = MakeNode("logic_node", registry->endpoint());
  auto worker = MakeNode("haptic_node", registry->endpoint());
  ASSERT_TRUE(watcher->Start().has_value());
  ASSERT_TRUE(worker->Start().has_value());
  ASSERT_TRUE(watcher->WaitForPeers({"haptic_node"}, kLong_ns).has_value());
  worker->Poll();  // then never again
  ASSERT_TRUE(Until([&] {
    WaitBriefly(*watcher);
    return FindEvent(*watcher, "node_stalled", "haptic_node");
  }));
  EXPECT_TRUE(watcher->IsAlive("haptic_node"));
  EXPECT_TRUE(Until([&] {
    worker->Poll();
    WaitBriefly(*watcher);
    return FindEvent(*watcher, "node_resumed", "haptic_node");
  }));
}

// Speaks to a node's data socket with datagrams made here.
class Forger {
 public:
  Forger(const std::string& endpoint, const std::string& topic) : socket_(*detail::UdpSocket::Bind("127.0.0.1")) {
    EXPECT_TRUE(detail::ParseEndpoint(endpoint, &to_));
    envelope_.topic = TopicId(topic);
    envelope_.session = 7;
  }
  void Send(std::uint64_t boot, std::uint64_t sequence, std::uint32_t digest, std::uint64_t session = 7) {
    core::HapticProxy proxy;
    proxy.cycle = sequence;
    envelope_.boot = boot;
    envelope_.header.sequence = sequence;
    envelope_.schema_digest = digest;
    envelope_.session = session;
    std::vector<std::uint8_t> bytes(1200);
    const std::size_t payload = codec_.Encode(proxy, 0, 1000, bytes.data() + kEnvelopeFixedBytes, 1000);
    bytes.resize(WriteEnvelope(envelope_, payload, bytes.data()));
    SendRaw(bytes);
  }
  void SendRaw(const std::vector<std::uint8_t>& bytes) { EXPECT_TRUE(socket_.Send(to_, bytes.data(), bytes.size())); }

 private:
  detail::UdpSocket socket_;
  sockaddr_in to_{};
  Envelope envelope_;
  LatestCodec<core::HapticProxy> codec_;
};

class ForgedTraffic : public testing::Test {
 protected:
  void SetUp() override {
    registry_ = MakeRegistry();
    watcher_ = MakeNode("watcher", registry_->endpoint());
    node_ = MakeNode("physics_node", registry_->endpoint());
    reader_ = &node_->ReadLatest<core::HapticProxy>(HapticProxyTopic("right"));
    ASSERT_TRUE(node_->Start().has_value());
    ASSERT_TRUE(watcher_->Start().has_value());
    ASSERT_TRUE(watcher_->WaitForPeers({"physics_node"}, kLong_ns).has_value());
    ASSERT_TRUE(node_->WaitForPeers({"watcher"}, kLong_ns).has_value());
    refused_before_ = node_->counters().refused;  // the watcher may have spoken before it was known
    forger_ = std::make_unique<Forger>(watcher_->Peers()[0].udp_endpoint, HapticProxyTopic("right"));
  }
  // Loopback delivers before sendto returns, so one look is enough.
  const TopicCounters& Take() {
    node_->Wait(core::MonotonicNow_ns() + kLong_ns);
    counters_ = node_->counters();
    return counters_.topics[0];
  }
  std::unique_ptr<Registry> registry_;
  std::unique_ptr<Node> watcher_, node_;
  LatestReader<core::HapticProxy>* reader_ = nullptr;
  std::unique_ptr<Forger> forger_;
  Counters counters_;
  std::uint64_t refused_before_ = 0;
  std::uint32_t digest_ = SchemaOf(MessageType::kHapticProxy).digest;
};

TEST_F(ForgedTraffic, NewestWinsAndEveryLossIsCounted) {
  for (const std::uint64_t sequence : {10, 11, 14, 13, 12, 20, 20, 14}) forger_->Send(5, sequence, digest_);
  const TopicCounters& topic = Take();
  EXPECT_EQ(reader_->value().cycle, 20u);
  EXPECT_EQ(topic.received, 6u);
  EXPECT_EQ(topic.reordered, 2u);  // 13, 12
  EXPECT_EQ(topic.repeated, 2u);   // 20, 14
  EXPECT_EQ(topic.dropped, 5u);    // 15 to 19
}

TEST_F(ForgedTraffic, ALaterBootWinsOverAHigherSequence) {
  forger_->Send(5, 1000, digest_);
  forger_->Send(6, 1, digest_);
  forger_->Send(5, 1001, digest_);  // a straggler from before the restart
  const TopicCounters& topic = Take();
  EXPECT_EQ(reader_->value().cycle, 1u);
  EXPECT_EQ(reader_->restarts(), 1u);
  EXPECT_EQ(topic.received, 2u);
  EXPECT_EQ(topic.reordered, 1u);
  EXPECT_EQ(topic.dropped, 0u);
}

TEST_F(ForgedTraffic, GarbageAndForeignDatagramsAreRefusedAndCounted) {
  forger_->Send(5, 1, digest_);
  forger_->Send(5, 2, digest_ + 1);  // another schema
  forger_->Send(5, 3, digest_, 8);   // another session
  std::mt19937_64 random(1);
  for (int i = 0; i < 100; ++i) {
    std::vector<std::uint8_t> noise(random() % 1400);
    for (std::uint8_t& byte : noise) byte = static_cast<std::uint8_t>(random());
    forger_->SendRaw(noise);
  }
  Take();
  EXPECT_EQ(reader_->value().cycle, 1u);
  EXPECT_EQ(counters_.refused - refused_before_, 102u);
  EXPECT_EQ(counters_.received, 1u);
}

TEST(Node, ObserverSeesTopicsByPatternAsText) {
  const auto registry = MakeRegistry();
  auto haptic = MakeNode("haptic_node", registry->endpoint());
  auto proxy_writer = haptic->WriteLatest<core::HapticProxy>(HapticProxyTopic("right"));
  auto command_writer = haptic->WriteLatest<core::DeviceCommand>(DeviceCommandTopic("right"));
  auto figures_writer = haptic->WriteState<Figures>(FiguresTopic("haptic_node"));
  ASSERT_TRUE(haptic->Start().has_value());
  NodeOptions options;
  options.name = "oos-echo";
  options.registry = registry->endpoint();
  options.session = 7;
  options.is_encrypted = false;
  options.is_observer = true;
  auto observer = std::move(*Node::Create(options));
  observer->Observe("haptic/*");
  observer->Observe("figures/*");
  ASSERT_TRUE(observer->Start().has_value());
  ASSERT_TRUE(Until([&] { return proxy_writer.has_subscribers(); }));
  EXPECT_FALSE(command_writer.has_subscribers());
  figures_writer.Set({{{"step_p50_us", 3.0}}});
  core::HapticProxy proxy;
  proxy.cycle = 4711;
  proxy_writer.Send(proxy);
  bool has_proxy = false, has_figures = false;
  EXPECT_TRUE(Until([&] {
    WaitBriefly(*observer);
    Observation seen;
    while (observer->PollObservation(&seen)) {
      has_proxy = has_proxy || (seen.topic == "haptic/right/proxy" && seen.writer == "haptic_node" &&
                                seen.Text().find("cycle: 4711") != std::string::npos);
      has_figures =
          has_figures || (seen.topic == "figures/haptic_node" && seen.Text().find("step_p50_us") != std::string::npos);
    }
    return has_proxy && has_figures;
  })) << has_proxy
      << has_figures;
  observer.reset();  // its end is no event for the others
  EXPECT_TRUE(Until([&] {
    WaitBriefly(*haptic);
    return haptic->Peers().empty();
  }));
  core::Event event;
  EXPECT_FALSE(haptic->PollEvent(&event)) << event.name;
}

#if !defined(__SANITIZE_THREAD__)
// The real thing: another process, kill -9.
TEST(Node, KilledProcessIsReportedWithinHalfASecond) {
  const auto registry = MakeRegistry();
  const std::string endpoint = registry->endpoint();
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    NodeOptions options;
    options.name = "physics_node";
    options.registry = endpoint;
    options.session = 7;
    options.is_encrypted = false;
    auto node = Node::Create(options);
    if (!node || !(*node)->Start()) _exit(1);
    for (;;) WaitBriefly(**node);
  }
  auto watcher = MakeNode("device_bridge", endpoint);
  ASSERT_TRUE(watcher->Start().has_value());
  const auto met = watcher->WaitForPeers({"physics_node"}, kLong_ns);
  kill(child, SIGKILL);
  const std::int64_t died = core::MonotonicNow_ns();
  ASSERT_TRUE(met.has_value()) << met.error().detail;
  ASSERT_TRUE(Until([&] {
    WaitBriefly(*watcher);
    return FindEvent(*watcher, "node_lost", "physics_node");
  }));
  EXPECT_LE(core::MonotonicNow_ns() - died, 500'000'000);
  waitpid(child, nullptr, 0);
}

// A reader whose whole process stands still is evicted, by name, when the writer cannot keep more for it; it comes
// back.
TEST(Node, StoppedEventReaderIsNamed) {
  const auto registry = MakeRegistry();
  const std::string endpoint = registry->endpoint();
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    NodeOptions options;
    options.name = "logic_node";
    options.registry = endpoint;
    options.session = 7;
    options.is_encrypted = false;
    auto node = Node::Create(options);
    if (!node) _exit(1);
    (*node)->ReadEvents();
    if (!(*node)->Start()) _exit(1);
    core::Event event;
    for (;;) {
      WaitBriefly(**node);
      while ((*node)->PollEvent(&event)) {
      }
    }
  }
  auto physics = MakeNode("physics_node", endpoint);
  const auto started = physics->Start();
  const auto met = physics->WaitForPeers({"logic_node"}, kLong_ns);
  const auto events = [&physics] {
    for (const Account& account : physics->Accounts()) {
      if (account.topic == kEventTopic && account.is_writer) return account;
    }
    return Account{};
  };
  const bool is_subscribed = Until([&] {
    WaitBriefly(*physics);
    physics->Emit({0, "physics_node", "probe", ""});
    return events().received > 0;
  });
  kill(child, SIGSTOP);
  bool is_named = false;
  Until([&] {
    for (int i = 0; i < 200; ++i) physics->Emit({0, "physics_node", "count", ""});
    WaitBriefly(*physics);
    is_named = is_named || FindEvent(*physics, "peer_evicted", "logic_node");
    return is_named || !physics->IsAlive("logic_node");
  });
  kill(child, SIGCONT);
  // It subscribes again, is told what it missed, and has its credit back: more than a whole credit gets through.
  const std::uint64_t received_before = events().received;
  const bool is_resumed = Until([&] {
    physics->Emit({0, "physics_node", "count", ""});
    WaitBriefly(*physics);
    for (int i = 0; i < 50; ++i) physics->Emit({0, "physics_node", "count", ""});
    return events().received > received_before + 2 * 1024 && events().dropped_for(DropReason::kOverrun) > 0;
  });
  const std::vector<PeerStatus> peers = physics->Peers();
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  ASSERT_TRUE(started.has_value());
  ASSERT_TRUE(met.has_value());
  ASSERT_TRUE(is_subscribed);
  EXPECT_TRUE(is_named);
  EXPECT_TRUE(is_resumed);
  ASSERT_EQ(peers.size(), 1u);
  EXPECT_GT(peers[0].events_dropped, 0u);
}
#endif

}  // namespace
}  // namespace bus
