// The calls of a real-time thread neither allocate nor lock once warm.

#if !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <mutex>
#include <thread>

#include "bus/log/tap_recorder.hpp"
#include "bus/security/datagram_guard.hpp"
#include "bus/testing/make_node.hpp"
#include "bus/testing/step_guard.hpp"
#include "core/clock.hpp"

namespace bus {
namespace {

std::unique_ptr<Node> MakeTappedNode(const std::string& name, const std::string& registry, log::Tap* tap = nullptr) {
  NodeOptions options;
  options.name = name;
  options.registry = registry;
  options.tap = tap;
  options.is_encrypted = false;
  return std::move(*Node::Create(options));
}

TEST(StepGuard, SeesAllocationsReleasesAndLocksOfItsOwnThreadOnly) {
  std::mutex mutex;
  std::atomic<int> word{0};
  step_guard::Arm();
  void* volatile memory = std::malloc(10);
  std::free(memory);
  EXPECT_EQ(step_guard::Disarm().allocations, 2u);
  step_guard::Arm();
  auto* volatile number = new int(3);
  delete number;
  EXPECT_EQ(step_guard::Disarm().allocations, 2u);
  word = 1;
  std::thread other([&] {
    while (word.load() == 1) {
    }
    {
      const std::lock_guard lock(mutex);
      delete new int(4);
    }
    word = 3;
  });
  step_guard::Arm();
  word.wait(0);  // holds something else: no wait
  word = 2;
  while (word.load() == 2) {
  }
  const step_guard::Counts counts = step_guard::Disarm();
  EXPECT_EQ(counts.locks, 0u);
  EXPECT_EQ(counts.allocations, 0u);
  other.join();
}

TEST(Node, RealTimeCallsNeitherAllocateNorLockOnceWarm) {
  const auto registry = std::move(*Registry::Create({.is_encrypted = false}));
  // With taps: recording is part of the real-time calls.
  const auto folder = std::filesystem::temp_directory_path() / ("no_alloc" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const auto haptic_recorder = std::move(*log::TapRecorder::Create({folder / "h.mcap", "haptic_node", {}, {}, 0, 0}));
  const auto physics_recorder = std::move(*log::TapRecorder::Create({folder / "p.mcap", "physics_node", {}, {}, 0, 0}));
  const auto haptic = MakeTappedNode("haptic_node", registry->endpoint(), haptic_recorder->tap());
  const auto physics = MakeTappedNode("physics_node", registry->endpoint(), physics_recorder->tap());
  auto contacts_writer = haptic->WriteLatest<core::ContactSet>(ContactsTopic("haptic_node", "a/b"));
  auto proxy_writer = haptic->WriteLatest<core::HapticProxy>(HapticProxyTopic("right"));
  auto state_writer = physics->WriteLatest<core::PhysicsState>(kPhysicsStateTopic);
  auto& contacts_reader = physics->ReadLatest<core::ContactSet>(ContactsTopic("haptic_node", "a/b"));
  auto& proxy_reader = physics->ReadLatest<core::HapticProxy>(HapticProxyTopic("right"));
  proxy_reader.KeepHistory(8);
  auto& state_reader = haptic->ReadLatest<core::PhysicsState>(kPhysicsStateTopic);
  auto figures_writer = physics->WriteState<Figures>(FiguresTopic("physics_node"));
  auto& figures_reader = haptic->ReadState<Figures>(FiguresTopic("physics_node"));
  const Figures figures{{{"step_p50_us", 1.0}, {"cycles_with_contact", 2.0}}};
  physics->OwnParameters({"some.mass_kg"});
  haptic->ReadEvents();
  ASSERT_TRUE(haptic->Start().has_value());
  ASSERT_TRUE(physics->Start().has_value());
  while (!contacts_writer.has_subscribers() || !state_writer.has_subscribers() || !proxy_writer.has_subscribers()) {
  }
  core::ContactSet contacts;
  contacts.planes.resize(core::kMaxContactPlanes);
  core::HapticProxy proxy;
  core::PhysicsState state;
  state.bodies.resize(core::kMaxBodies);
  state.mechanisms.resize(core::kMaxMechanisms);
  const core::Event event{0, "physics_node", "attach", "module_old to gripper"};
  core::Event heard;
  for (std::string* text : {&heard.source, &heard.name, &heard.detail}) text->reserve(256);
  core::ParameterChange change{"some.mass_kg", 2.0};
  change.name.reserve(256);
  const std::string owner = "physics_node";
  ParameterAck ack;
  for (std::string* text : {&ack.owner, &ack.why}) text->reserve(256);
  std::uint64_t ticket = 0;
  std::uint64_t heard_events = 0, answered = 0;
  const auto cycle = [&](int i) {
    contacts_writer.Send(contacts);
    proxy_writer.Send(proxy);
    while (contacts_reader.value().header.sequence != contacts.header.sequence ||
           proxy_reader.value().header.sequence != proxy.header.sequence) {
      physics->Wait(core::MonotonicNow_ns() + core::kNanosecondsPerSecond);
    }
    state_writer.Send(state);
    while (state_reader.value().header.sequence != state.header.sequence) {
      haptic->Wait(core::MonotonicNow_ns() + core::kNanosecondsPerSecond);
    }
    physics->Emit(event);
    if (i % 4 == 0) haptic->PostParameter(owner, change);
    if (i % 8 == 0) figures_writer.Set(figures);
    while (physics->PollParameter(&change, &ticket)) physics->AckParameter(ticket, 1, true);
    while (haptic->PollAck(&ack)) ++answered;
    while (haptic->PollEvent(&heard)) ++heard_events;
  };
  for (int i = 0; i < 400; ++i) cycle(i);
  step_guard::Arm();
  for (int i = 0; i < 2000; ++i) cycle(i);
  const step_guard::Counts counts = step_guard::Disarm();
  EXPECT_EQ(counts.allocations, 0u);
  EXPECT_EQ(counts.locks, 0u);
  if (counts.allocations + counts.locks != 0) step_guard::PrintFirst(STDERR_FILENO);
  EXPECT_EQ(contacts_reader.value().header.sequence, 2400u);
  EXPECT_NE(proxy_reader.Sample(2393), nullptr);
  EXPECT_GT(heard_events, 0u);
  EXPECT_GT(answered, 0u);
  EXPECT_GT(figures_reader.version(), 100u);
  testing::ExpectAccountsClose({haptic.get(), physics.get()});
  ASSERT_TRUE(haptic_recorder->Stop());
  EXPECT_GT(haptic_recorder->writer().num_messages(), 3 * 2400u);
  EXPECT_EQ(haptic_recorder->writer().num_dropped(), 0u);
  std::filesystem::remove_all(folder);
}

// The step thread also takes over new rosters.
TEST(DatagramGuard, SealsOpensAndTakesKeysOverWithoutAllocationOrLock) {
  detail::DatagramGuard writer(7, true), reader(7, true);
  const detail::SessionKey key{1, 2, 3};
  writer.SetSessionKey(key, 1);
  reader.SetSessionKey(key, 2);
  detail::KnownSenders senders;
  for (std::uint64_t instance = 1; instance <= 100; ++instance) {
    senders.push_back(reader.Know(static_cast<std::uint32_t>(instance), instance));
  }
  Envelope envelope;
  envelope.session = 7;
  envelope.node = 1;
  std::array<std::uint8_t, kMaxDatagramBytes> bytes{};
  int taken = 0;
  for (int i = 0; i < 100; ++i) {
    reader.SetSenders(senders);
    step_guard::Arm();
    reader.TakeSenders();
    const std::size_t size = writer.SealData(bytes.data(), WriteEnvelopeToSeal(envelope, 300, bytes.data()));
    std::span<const std::uint8_t> payload;
    Envelope got;
    taken += reader.OpenData({bytes.data(), size}, &got, &payload) == detail::Refusal::kNone ? 1 : 0;
    const step_guard::Counts counts = step_guard::Disarm();
    ASSERT_EQ(counts.allocations + counts.locks, 0u);
  }
  EXPECT_EQ(taken, 100);
}

}  // namespace
}  // namespace bus

#endif
