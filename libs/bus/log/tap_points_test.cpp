// The taps of two nodes on the bus.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "bus/log/mcap_reader.hpp"
#include "bus/log/recorded_message.hpp"
#include "bus/log/tap_recorder.hpp"
#include "bus/testing/make_node.hpp"
#include "core/clock.hpp"
#include "proto/bus.pb.h"

namespace bus::log {
namespace {

constexpr std::int64_t kLong_ns = 30 * core::kNanosecondsPerSecond;

struct Entry {
  Channel channel;
  Message message;
};

class TapPointsTest : public ::testing::Test {
 protected:
  TapPointsTest() { std::filesystem::create_directories(folder_); }
  ~TapPointsTest() override { std::filesystem::remove_all(folder_); }

  std::unique_ptr<TapRecorder> Recorder(const std::string& name) {
    return std::move(*TapRecorder::Create({folder_ / (name + ".mcap"), name, {}, {}, 0, 0}));
  }
  static std::unique_ptr<Node> MakeNode(const std::string& name, const Registry& registry, TapRecorder* recorder) {
    NodeOptions options;
    options.name = name;
    options.registry = registry.endpoint();
    options.is_encrypted = false;
    options.tap = recorder->tap();
    return std::move(*Node::Create(options));
  }
  // By channel.
  std::map<std::string, std::vector<Entry>> Read(const std::string& name) {
    std::map<std::string, std::vector<Entry>> entries;
    const auto contents = ReadMcap(folder_ / (name + ".mcap"), [&](const Channel& channel, const Message& message) {
      entries[channel.topic].push_back({channel, message});
    });
    EXPECT_TRUE(contents) << (contents ? "" : contents.error().detail);
    return entries;
  }
  template <class M>
  static M Parse(const Entry& entry) {
    M message;
    EXPECT_TRUE(message.ParseFromArray(entry.message.data.data(), static_cast<int>(entry.message.data.size())));
    return message;
  }

 private:
  std::filesystem::path folder_ =
      std::filesystem::path(::testing::TempDir()) / ("tap_points" + std::to_string(::getpid()));
};

TEST_F(TapPointsTest, EveryClassIsRecordedWhereItIsSentAndWhereItIsTaken) {
  const auto registry = std::move(*Registry::Create({.is_encrypted = false}));
  const auto a_recorder = Recorder("haptic_node");
  const auto b_recorder = Recorder("physics_node");
  auto a = MakeNode("haptic_node", *registry, a_recorder.get());
  auto b = MakeNode("physics_node", *registry, b_recorder.get());
  auto unread = a->WriteLatest<core::PhysicsState>(kPhysicsStateTopic);
  auto proxies = a->WriteLatest<core::HapticProxy>(HapticProxyTopic("right"));
  auto figures = a->WriteState<Figures>(FiguresTopic("haptic_node"));
  auto& proxy = b->ReadLatest<core::HapticProxy>(HapticProxyTopic("right"));
  auto& heard_figures = b->ReadState<Figures>(FiguresTopic("haptic_node"));
  b->ReadEvents();
  b->OwnParameters({"some.mass_kg"});
  ASSERT_TRUE(a->Start());
  ASSERT_TRUE(b->Start());
  ASSERT_TRUE(a->WaitForPeers({"physics_node"}, kLong_ns));  // events go to known peers only

  core::PhysicsState many;
  many.bodies.resize(60);
  for (std::size_t i = 0; i < many.bodies.size(); ++i) many.bodies[i].object = static_cast<std::uint16_t>(i);
  unread.Send(many);  // nobody reads it: recorded all the same
  Figures value;
  value.items.push_back({"cycles", 5.0});
  ASSERT_TRUE(figures.Set(value, "one"));
  ASSERT_TRUE(a->Emit({-7, "haptic_node", "ready", "loop starts"}));
  const std::uint64_t request = a->PostParameter(
      "physics_node", {"some.mass_kg", 2.5, core::ChangeManner::kRamped, 0.5}, 20 * core::kNanosecondsPerSecond);
  core::HapticProxy sent;
  core::Event event;
  core::ParameterChange change;
  ParameterAck ack;
  std::uint64_t ticket = 0;
  bool is_heard = false, is_acked = false;
  const std::int64_t end_ns = core::MonotonicNow_ns() + kLong_ns;
  while ((!is_heard || !is_acked || !proxy.has_value() || !heard_figures.has_value()) &&
         core::MonotonicNow_ns() < end_ns) {
    proxies.Send(sent);
    b->Wait(core::MonotonicNow_ns() + 1'000'000);
    while (b->PollEvent(&event)) is_heard = is_heard || event.name == "ready";
    while (b->PollParameter(&change, &ticket)) b->AckParameter(ticket, 42, true, "", 0.25);
    a->Poll();
    while (a->PollAck(&ack)) is_acked = true;
  }
  ASSERT_TRUE(is_heard && is_acked && proxy.has_value() && heard_figures.has_value());
  testing::ExpectAccountsClose({a.get(), b.get()});
  const std::uint64_t taken_sequence = proxy.value().header.sequence;
  ASSERT_TRUE(a_recorder->Stop());
  ASSERT_TRUE(b_recorder->Stop());

  auto of_a = Read("haptic_node");
  RecordedMessage<core::PhysicsState> assembler;
  const core::PhysicsState* whole = nullptr;
  const auto& parts = of_a.at(kPhysicsStateTopic);
  EXPECT_GT(parts.size(), 1U);
  for (const Entry& part : parts) whole = assembler.Take(SplitRecorded(part.message.data));
  ASSERT_NE(whole, nullptr);
  ASSERT_EQ(whole->bodies.size(), many.bodies.size());
  EXPECT_EQ(whole->bodies[59].object, 59);
  EXPECT_EQ(of_a.at(FiguresTopic("haptic_node")).at(0).channel.metadata.at("key"), "one");
  const auto emitted = Parse<oos::Event>(of_a.at("event").at(0));
  EXPECT_EQ(emitted.time_ns(), -7);
  EXPECT_EQ(emitted.source() + emitted.name() + emitted.detail(), "haptic_nodereadyloop starts");
  const auto posted = Parse<oos::ParameterChange>(of_a.at("param/set").at(0));
  EXPECT_EQ(of_a.at("param/set").at(0).message.sequence, request);
  EXPECT_EQ(of_a.at("param/set").at(0).channel.metadata.at("key"), "physics_node");
  EXPECT_EQ(posted.name(), "some.mass_kg");
  EXPECT_EQ(posted.value(), 2.5);
  EXPECT_EQ(posted.manner(), 1U);
  EXPECT_EQ(posted.ramp_s(), 0.5);
  const auto answer = Parse<oos::ParameterReply>(of_a.at("taken/haptic_node/param/ack").at(0));
  EXPECT_EQ(answer.request(), request);
  EXPECT_TRUE(answer.is_accepted());
  EXPECT_EQ(answer.tick(), 42U);
  EXPECT_EQ(answer.injected_j(), 0.25);

  auto of_b = Read("physics_node");
  const auto& taken = of_b.at("taken/physics_node/" + HapticProxyTopic("right"));
  EXPECT_EQ(taken.back().message.sequence, taken_sequence);
  EXPECT_EQ(taken.back().channel.metadata.at("reader"), "physics_node");
  EXPECT_EQ(Parse<oos::Figures>(of_b.at("taken/physics_node/" + FiguresTopic("haptic_node")).at(0)).value(0), 5.0);
  EXPECT_EQ(Parse<oos::ParameterChange>(of_b.at("taken/physics_node/param/set").at(0)).value(), 2.5);
  EXPECT_EQ(Parse<oos::ParameterReply>(of_b.at("param/ack").at(0)).tick(), 42U);
  bool is_event_taken = false;
  for (const Entry& entry : of_b.at("taken/physics_node/event")) {
    is_event_taken = is_event_taken || Parse<oos::Event>(entry).name() == "ready";
  }
  EXPECT_TRUE(is_event_taken);
}

}  // namespace
}  // namespace bus::log
