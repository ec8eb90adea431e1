// Every node detects by itself, and reports by name, which peers live, stall, die or leave.

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <memory>
#include <string>
#include <vector>

#include "bus/testing/make_node.hpp"

namespace bus {
namespace {

using testing::ExpectAccountsClose;
using testing::kLong_ns;
using testing::MakeNode;
using testing::MakeRegistry;
using testing::TakeEvent;
using testing::Until;
using testing::WaitBriefly;

TEST(Liveness, ASilentPeerIsReportedByNameWithinHalfASecondAndWelcomedBack) {
  const auto registry = MakeRegistry();
  auto watcher = MakeNode("device_bridge", registry->endpoint());
  ASSERT_TRUE(watcher->Start().has_value());
  auto victim = MakeNode("haptic_node", registry->endpoint(), false);
  ASSERT_TRUE(victim->Start().has_value());
  ASSERT_TRUE(watcher->WaitForPeers({"haptic_node"}, kLong_ns).has_value());
  ASSERT_TRUE(Until([&] { return TakeEvent(*watcher, "node_found", "haptic_node"); }));

  victim.reset();  // without goodbye: sockets closed as after kill -9
  const std::int64_t died = core::MonotonicNow_ns();
  ASSERT_TRUE(Until([&] {
    WaitBriefly(*watcher);
    return TakeEvent(*watcher, "node_lost", "haptic_node");
  }));
  EXPECT_LE(core::MonotonicNow_ns() - died, 500'000'000);
  EXPECT_FALSE(watcher->IsAlive("haptic_node"));

  // Started again at once: the registry must find out that the first is dead, not refuse the second.
  auto again = MakeNode("haptic_node", registry->endpoint());
  const auto started = again->Start(kLong_ns);
  ASSERT_TRUE(started.has_value()) << started.error().detail;
  ASSERT_TRUE(Until([&] {
    WaitBriefly(*watcher);
    return TakeEvent(*watcher, "node_found", "haptic_node");
  }));
  const auto peers = watcher->Peers();
  ASSERT_EQ(peers.size(), 1u);
  EXPECT_EQ(peers[0].restarts, 1u);
  again.reset();  // with goodbye: no fault
  EXPECT_TRUE(Until([&] {
    WaitBriefly(*watcher);
    return TakeEvent(*watcher, "node_left", "haptic_node");
  }));
  ExpectAccountsClose({watcher.get()});
}

// The writer's last messages wait in the reader's socket when it leaves: they count as lost until they are read.
TEST(Liveness, TheAccountOfALeavingWriterIsSettledAtOnce) {
  const auto registry = MakeRegistry();
  auto reader = MakeNode("device_bridge", registry->endpoint());
  reader->ReadLatest<core::HapticProxy>("haptic/right/proxy");
  ASSERT_TRUE(reader->Start().has_value());
  auto writer = MakeNode("haptic_node", registry->endpoint());
  auto proxies = writer->WriteLatest<core::HapticProxy>("haptic/right/proxy");
  ASSERT_TRUE(writer->Start().has_value());
  core::HapticProxy proxy;
  ASSERT_TRUE(Until([&] {
    WaitBriefly(*writer);
    return proxies.has_subscribers();
  }));
  for (int i = 0; i < 10; ++i) EXPECT_EQ(proxies.Send(proxy), 1);
  writer.reset();

  const auto book = [&] { return reader->Accounts().at(0); };
  ASSERT_TRUE(Until([&] { return !reader->Accounts().empty() && !reader->IsAlive("haptic_node"); }));
  EXPECT_TRUE(book().is_settled()) << Describe(book());
  EXPECT_EQ(book().sent, 10u);
  EXPECT_EQ(book().dropped_in_all(), 10u);
  ASSERT_TRUE(Until([&] {
    WaitBriefly(*reader);
    return book().received == 10;
  })) << Describe(book());
  EXPECT_EQ(book().dropped_in_all(), 0u);
}

// A node whose step thread hangs is distinguished from one that died or restarted.
TEST(Liveness, AStallIsDistinguishedFromDeath) {
  const auto registry = MakeRegistry();
  auto watcher = MakeNode("logic_node", registry->endpoint());
  auto worker = MakeNode("haptic_node", registry->endpoint());
  ASSERT_TRUE(watcher->Start().has_value());
  ASSERT_TRUE(worker->Start().has_value());
  ASSERT_TRUE(watcher->WaitForPeers({"haptic_node"}, kLong_ns).has_value());
  worker->Poll();  // then never again
  ASSERT_TRUE(Until([&] {
    WaitBriefly(*watcher);
    return TakeEvent(*watcher, "node_stalled", "haptic_node");
  }));
  EXPECT_TRUE(watcher->IsAlive("haptic_node"));
  EXPECT_TRUE(Until([&] {
    worker->Poll();
    WaitBriefly(*watcher);
    return TakeEvent(*watcher, "node_resumed", "haptic_node");
  }));
  ExpectAccountsClose({watcher.get(), worker.get()});
}

#if !defined(__SANITIZE_THREAD__)
// A node in another process, which reads events, and the registry of both.
struct Elsewhere {
  pid_t child = -1;
  std::unique_ptr<Registry> registry;
};

// Forks while there is only one thread: allocator locks held by other threads would stay locked in the child.
Elsewhere StartElsewhere(const std::string& name) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) return {};
  const pid_t child = fork();
  if (child != 0) {
    Elsewhere elsewhere{child, MakeRegistry()};
    const std::string endpoint = elsewhere.registry->endpoint();
    EXPECT_EQ(write(ends[1], endpoint.data(), endpoint.size()), static_cast<ssize_t>(endpoint.size()));
    close(ends[0]);
    close(ends[1]);
    return elsewhere;
  }
  close(ends[1]);
  std::array<char, 100> endpoint{};
  if (read(ends[0], endpoint.data(), endpoint.size() - 1) <= 0) _exit(1);
  const auto node = MakeNode(name, endpoint.data());
  node->ReadEvents();
  if (!node->Start()) _exit(1);
  for (core::Event event;;) {
    WaitBriefly(*node);
    while (node->PollEvent(&event)) {
    }
  }
}

TEST(Liveness, AKilledProcessIsReportedWithinHalfASecond) {
  const Elsewhere elsewhere = StartElsewhere("physics_node");
  const pid_t child = elsewhere.child;
  ASSERT_GE(child, 0);
  const std::string endpoint = elsewhere.registry->endpoint();
  auto watcher = MakeNode("device_bridge", endpoint);
  ASSERT_TRUE(watcher->Start().has_value());
  const auto met = watcher->WaitForPeers({"physics_node"}, kLong_ns);
  kill(child, SIGKILL);
  const std::int64_t died = core::MonotonicNow_ns();
  ASSERT_TRUE(met.has_value()) << met.error().detail;
  ASSERT_TRUE(Until([&] {
    WaitBriefly(*watcher);
    return TakeEvent(*watcher, "node_lost", "physics_node");
  }));
  EXPECT_LE(core::MonotonicNow_ns() - died, 500'000'000);
  waitpid(child, nullptr, 0);
  ExpectAccountsClose({watcher.get()});
}

// A reader whose process is stopped is evicted, by name, when the writer's log is full; then it resumes.
TEST(Liveness, AStoppedEventReaderIsEvictedByName) {
  const Elsewhere elsewhere = StartElsewhere("logic_node");
  const pid_t child = elsewhere.child;
  ASSERT_GE(child, 0);
  const std::string endpoint = elsewhere.registry->endpoint();
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
    is_named = is_named || TakeEvent(*physics, "peer_evicted", "logic_node");
    return is_named || !physics->IsAlive("logic_node");
  });
  kill(child, SIGCONT);
  // It subscribes again, learns what it missed, and has its credit back: more than one credit gets through.
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
