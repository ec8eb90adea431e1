#include "bus/node.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>

#include "bus/testing/make_node.hpp"
#include "bus/wire/schema.hpp"

namespace bus {
namespace {

using testing::ExpectAccountsClose;
using testing::kLong_ns;
using testing::MakeNode;
using testing::MakeRegistry;
using testing::TakeEvent;
using testing::Until;
using testing::WaitBriefly;

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
  // The counters of the other side come with its heartbeats.
  EXPECT_TRUE(Until([&] {
    WaitBriefly(*physics);
    const auto peers = physics->Peers();
    return peers.size() == 1 && peers[0].counters.received == 100 && !peers[0].counters.topics.empty() &&
           peers[0].counters.topics[0].received == 100;
  }));
  ExpectAccountsClose({physics.get(), visual.get()});
}

// Its payload has 0 bytes.
TEST(Node, AMessageOfNothingButDefaultsArrives) {
  const auto registry = MakeRegistry();
  auto physics = MakeNode("physics_node", registry->endpoint());
  auto visual = MakeNode("visual_node", registry->endpoint());
  auto writer = physics->WriteLatest<core::PhysicsState>(kPhysicsStateTopic);
  auto& reader = visual->ReadLatest<core::PhysicsState>(kPhysicsStateTopic);
  ASSERT_TRUE(physics->Start().has_value());
  ASSERT_TRUE(visual->Start().has_value());
  ASSERT_TRUE(Until([&] { return writer.has_subscribers(); }));
  core::PhysicsState state;
  EXPECT_EQ(writer.Send(state), 1);
  EXPECT_TRUE(Until([&] {
    WaitBriefly(*visual);
    return reader.has_value();
  }));
  EXPECT_EQ(visual->counters().dropped, 0u);
  ExpectAccountsClose({physics.get(), visual.get()});
}

// Nothing takes from the queues before Start().
TEST(Node, OverflowsOfTheStepThreadsQueuesAreCountedByTopic) {
  auto node = MakeNode("physics_node", "tcp://127.0.0.1:1");
  auto writer = node->WriteState<Figures>(FiguresTopic("physics_node"));
  node->OwnParameters({"cap"});
  const Figures figures{{{"n", 1.0}}};
  const Figures large{{{std::string(100'000, 'x'), 1.0}}};
  EXPECT_FALSE(writer.Set(large));
  EXPECT_FALSE(writer.Set(large));
  std::uint64_t states = 0, calls = 0, events = 0;
  for (int i = 0; i < 1000; ++i) {
    states += writer.Set(figures) ? 0 : 1;
    calls += node->PostParameter("", {"cap", 1.0}) == 0 ? 1 : 0;
    events += node->Emit({0, "physics_node", "count", ""}) ? 0 : 1;
    node->AckParameter(1, 1, true);
  }
  const Counters counters = node->counters();
  const auto find = [&counters](const std::string& topic, bool is_written) {
    for (const TopicCounters& it : counters.topics) {
      if (it.topic == topic && it.is_written == is_written) return it;
    }
    return TopicCounters{};
  };
  const TopicCounters state = find(FiguresTopic("physics_node"), true);
  EXPECT_EQ(state.oversize, 2u);
  EXPECT_GT(states, 0u);
  EXPECT_EQ(state.overflows, states);
  EXPECT_EQ(state.dropped, states + 2);
  EXPECT_GT(calls, 0u);
  EXPECT_EQ(find(kParameterTopic, true).overflows, calls);
  EXPECT_EQ(find(kEventTopic, true).overflows, events);
  const std::uint64_t answers = find(kParameterTopic, false).overflows;
  EXPECT_EQ(answers, calls) << "both queues have the same room";
  EXPECT_EQ(counters.dropped, states + 2 + calls + events + answers);
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
  ExpectAccountsClose({nodes[0].get(), nodes[1].get(), nodes[2].get()});
}

TEST(Node, DataFlowsWithoutTheRegistryAndANewOneLearnsAllNodes) {
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
  ExpectAccountsClose({source.get(), sink.get(), late.get()});
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
  EXPECT_EQ(*FindFigure(figures_reader.values().at("b"), "two"), 2.0);
  for (int i = 0; i < 200; ++i) {
    status.step = "step " + std::to_string(i);
    ASSERT_TRUE(Until([&] { return status_writer.Set(status); }));
  }
  EXPECT_TRUE(Until([&] {
    WaitBriefly(*visual);
    return status_reader.value().step == "step 199";
  }));
  ExpectAccountsClose({logic.get(), visual.get()});
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
  // More than the reader's credit in flight: the credit must hold the emitter back, not lose events.
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
  ExpectAccountsClose({physics.get(), logic.get()});
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
  ExpectAccountsClose({owner.get(), deaf.get(), caller.get()});
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

TEST(Node, WrongDeclarationsAreReportedAtStart) {
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
  ExpectAccountsClose({sink.get()});
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
  observer.reset();  // its end is not reported to the others
  EXPECT_TRUE(Until([&] {
    WaitBriefly(*haptic);
    return haptic->Peers().empty();
  }));
  core::Event event;
  EXPECT_FALSE(haptic->PollEvent(&event)) << event.name;
  ExpectAccountsClose({haptic.get()});
}

}  // namespace
}  // namespace bus
