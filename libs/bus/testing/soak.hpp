#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "bus/figures.hpp"
#include "bus/testing/make_node.hpp"
#include "bus/testing/own_network.hpp"

// All classes under lost packets, broken connections, cuts, restarts and a slow subscriber at once.
namespace bus::testing {

class Soak {
 public:
  Soak(std::uint64_t seed, OwnNetwork* network) : random_(seed), network_(network), registry_(MakeRegistry()) {
    for (const char* name : {"physics_node", "haptic_node", "logic_node", "visual_node", "device_bridge"}) {
      Participant& participant = participants_[name];
      participant.name = name;
      participant.is_slow = participant.name == "device_bridge";
      StartNode(participant, true);
    }
  }

  void Run(std::int64_t duration_ns) {
    const std::int64_t start = core::MonotonicNow_ns();
    std::int64_t next_trouble = start + kSecond_ns / 2;
    std::int64_t trouble_ends = 0;
    for (std::int64_t now = start; now < start + duration_ns; now = core::MonotonicNow_ns()) {
      if (trouble_ends != 0 && now > trouble_ends) {
        EXPECT_TRUE(network_->Mend() && network_->Lose(kLost_per_mille));
        trouble_ends = 0;
      }
      if (trouble_ends == 0 && now > next_trouble) {
        trouble_ends = now + MakeTrouble();
        next_trouble = now + kSecond_ns + static_cast<std::int64_t>(random_() % 2'000) * 1'000'000;
      }
      // The slow one sleeps three seconds of four.
      const bool is_asleep = (now - start) % (4 * kSecond_ns) > kSecond_ns;
      for (auto& [name, participant] : participants_) {
        Write(participant, (now - start) / 1'000'000);
        if (!participant.is_slow || !is_asleep) Read(participant);
      }
    }
    EXPECT_TRUE(network_->Mend());
    std::vector<Node*> nodes;
    for (auto& [name, participant] : participants_) nodes.push_back(participant.node.get());
    // All nodes have found each other again, and nothing is under way.
    EXPECT_TRUE(Until([&] {
      bool are_together = true;
      for (auto& [name, participant] : participants_) {
        Read(participant);
        for (const auto& [other, ignored] : participants_) {
          are_together = are_together && (other == name || participant.node->IsAlive(other));
        }
      }
      return are_together;
    }));
    ExpectAccountsClose(nodes, 3 * kLong_ns);
    Print();
    EXPECT_GT(OverrunOfTheSlow(), 0U) << "the slow subscriber was not slow enough";
  }

 private:
  static constexpr std::int64_t kSecond_ns = core::kNanosecondsPerSecond;
  static constexpr int kLost_per_mille = 10;
  static constexpr std::int64_t kBurst = 200;  // within the ring of a node's events

  struct Participant {
    std::string name;
    std::unique_ptr<Node> node;
    int life = 0;
    bool is_slow = false;
    LatestWriter<core::PhysicsState> physics;
    LatestWriter<core::HapticProxy> proxy;
    StateWriter<core::LogicStatus> status;
    StateWriter<Figures> figures;
    std::uint64_t emitted = 0;
    std::int64_t written_ms = -1;
    std::map<std::string, std::uint64_t> last_event;  // by "<source> <life>"
  };

  void StartNode(Participant& it, bool sends_goodbye) {
    ++it.life;
    it.emitted = 0;
    it.last_event.clear();
    it.node = MakeNode(it.name, registry_->endpoint(), sends_goodbye);
    it.physics = {};
    it.proxy = {};
    it.status = {};
    if (it.name == "physics_node") it.physics = it.node->WriteLatest<core::PhysicsState>(kPhysicsStateTopic);
    if (it.name == "haptic_node") it.proxy = it.node->WriteLatest<core::HapticProxy>(HapticProxyTopic("right"));
    if (it.name == "logic_node") it.status = it.node->WriteState<core::LogicStatus>(kLogicStatusTopic);
    it.figures = it.node->WriteState<Figures>(FiguresTopic(it.name));
    if (it.name != "physics_node") it.node->ReadLatest<core::PhysicsState>(kPhysicsStateTopic);
    if (it.name != "haptic_node") it.node->ReadLatest<core::HapticProxy>(HapticProxyTopic("right"));
    if (it.name != "logic_node") it.node->ReadState<core::LogicStatus>(kLogicStatusTopic);
    for (const auto& [other, ignored] : participants_) {
      if (other != it.name) it.node->ReadState<Figures>(FiguresTopic(other));
    }
    it.node->ReadEvents();
    EXPECT_TRUE(it.node->Start(0).has_value());
  }

  // Returns how long it lasts.
  std::int64_t MakeTrouble() {
    ++troubles_;
    switch (random_() % 4) {
      case 0:
        EXPECT_TRUE(network_->BreakConnections());
        return kSecond_ns / 10;
      case 1:
        EXPECT_TRUE(network_->Cut());
        return kSecond_ns / 5 + static_cast<std::int64_t>(random_() % 800) * 1'000'000;
      default: {
        constexpr std::array kRestarted = {"haptic_node", "logic_node", "visual_node"};
        Participant& it = participants_[kRestarted[random_() % kRestarted.size()]];
        it.node.reset();
        StartNode(it, random_() % 2 == 0);
        ++restarts_;
        return 0;
      }
    }
  }

  void Write(Participant& it, std::int64_t now_ms) {
    if (now_ms == it.written_ms) return;
    const std::int64_t passed_ms = now_ms - std::exchange(it.written_ms, now_ms);
    if (it.name == "physics_node") {
      core::PhysicsState state;
      it.physics.Send(state);
      // By the clock: also on a busy machine more than the log keeps for a reader that sleeps.
      for (std::int64_t i = 0; i < std::min<std::int64_t>(4 * passed_ms, kBurst); ++i) Emit(it);
    }
    if (it.name == "haptic_node") {
      core::HapticProxy proxy;
      it.proxy.Send(proxy);
    }
    if (now_ms % 16 == 0) {
      Emit(it);
      it.figures.Set({{{"n", static_cast<double>(now_ms)}}}, now_ms % 32 == 0 ? "even" : "odd");
      if (it.name == "logic_node") it.status.Set({});
    }
  }

  void Emit(Participant& it) {
    const std::string detail = std::to_string(it.life) + " " + std::to_string(it.emitted + 1);
    if (it.node->Emit({0, it.name, "count", detail})) ++it.emitted;
  }

  void Read(Participant& it) {
    it.node->Wait(core::MonotonicNow_ns() + 100'000);
    core::Event event;
    while (it.node->PollEvent(&event)) {
      if (event.name == "peer_evicted") ++evictions_[event.detail];
      if (event.name != "count") continue;
      const std::size_t space = event.detail.find(' ');
      std::uint64_t& last = it.last_event[event.source + " " + event.detail.substr(0, space)];
      const std::uint64_t number = std::stoull(event.detail.substr(space + 1));
      EXPECT_GT(number, last) << it.name << ": twice, or out of order, of " << event.source;
      last = number;
    }
  }

  // Evicted, or cut off for longer than the writers' logs reach back.
  std::uint64_t OverrunOfTheSlow() {
    std::uint64_t overrun = 0;
    for (const Account& account : participants_["device_bridge"].node->Accounts()) {
      if (!account.is_writer) overrun += account.dropped[static_cast<std::size_t>(DropReason::kOverrun)];
    }
    return overrun;
  }

  void Print() {
    Account sums[5];
    for (auto& [name, participant] : participants_) {
      for (const Account& account : participant.node->Accounts()) {
        if (account.is_writer) continue;
        Account& sum = sums[static_cast<std::size_t>(account.topic_class)];
        sum.sent += account.sent;
        sum.received += account.received;
        for (std::size_t i = 0; i < kNumDropReasons; ++i) sum.dropped[i] += account.dropped[i];
      }
    }
    for (const TopicClass of : {TopicClass::kLatest, TopicClass::kState, TopicClass::kEvent}) {
      Account& sum = sums[static_cast<std::size_t>(of)];
      sum.topic = std::string(NameOf(of));
      sum.topic_class = of;
      sum.peer = "all";
      std::printf("%s\n", Describe(sum).c_str());
    }
    std::printf("%d troubles, %d restarts, reported evictions of the slow one: %d\n", troubles_, restarts_,
                evictions_["device_bridge"]);
  }

  std::mt19937_64 random_;
  OwnNetwork* network_;
  std::unique_ptr<Registry> registry_;
  std::map<std::string, Participant> participants_;
  std::map<std::string, int> evictions_;
  int troubles_ = 0, restarts_ = 0;
};

inline void RunSoak(std::int64_t duration_ns) {
  const std::uint64_t seed = std::random_device()();
  SCOPED_TRACE("seed " + std::to_string(seed));
  const std::string why = OwnNetwork::Run([&](OwnNetwork& network) {
    Soak soak(seed, &network);
    soak.Run(duration_ns);
  });
  if (!why.empty()) GTEST_SKIP() << why;
}

}  // namespace bus::testing
