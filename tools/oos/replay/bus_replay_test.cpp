#include "tools/oos/replay/bus_replay.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "bus/log/mcap_reader.hpp"
#include "bus/log/recorded_message.hpp"
#include "bus/log/recorder.hpp"
#include "bus/testing/make_node.hpp"
#include "bus/wire/codec.hpp"
#include "proto/logic.pb.h"

namespace oos {
namespace {

constexpr std::int64_t kBegin_ns = 5'000'000'000;
constexpr std::uint64_t kTicks = 200;

core::PhysicsState StateAt(std::uint64_t tick) {
  core::PhysicsState state;
  state.tick = tick;
  state.bodies.resize(tick % 50 == 7 ? 60 : 2);  // every now and then one that takes several datagrams
  for (std::size_t i = 0; i < state.bodies.size(); ++i) {
    state.bodies[i].object = static_cast<std::uint16_t>(i);
    state.bodies[i].X_WO.translation.x = 1e-3 * static_cast<double>(tick) + static_cast<double>(i);
  }
  return state;
}

std::string TextOf(const core::PhysicsState& state) {
  std::string text = "tick " + std::to_string(state.tick);
  for (const core::BodyState& body : state.bodies) {
    text += ", " + std::to_string(body.object) + " at " + std::to_string(body.X_WO.translation.x);
  }
  return text;
}

// The messages on each topic as text, however they were split into datagrams.
using Said = std::map<std::string, std::vector<std::string>>;

Said Read(const std::filesystem::path& file) {
  Said said;
  bus::log::RecordedMessage<core::PhysicsState> states;
  const auto done = bus::log::ReadMcap(file, [&](const bus::log::Channel& channel, const bus::log::Message& message) {
    const auto recorded = bus::log::SplitRecorded(message.data);
    if (channel.topic != "physics/state") {
      said[channel.topic].emplace_back(recorded.payload.begin(), recorded.payload.end());
    } else if (const core::PhysicsState* state = states.Take(recorded); state != nullptr) {
      said[channel.topic].push_back(TextOf(*state));
    }
  });
  EXPECT_TRUE(done) << done.error().detail;
  return said;
}

class BusReplayTest : public ::testing::Test {
 protected:
  BusReplayTest() { Record(); }
  ~BusReplayTest() override {
    std::filesystem::remove(first_);
    std::filesystem::remove(second_);
  }

  static bus::Observation About(const std::string& topic, bus::TopicClass topic_class, bus::MessageType type,
                                std::uint64_t sequence, std::int64_t now_ns) {
    bus::Observation o;
    o.topic = topic;
    o.topic_class = topic_class;
    o.type = type;
    o.writer = "somebody";
    o.sequence = sequence;
    o.publish_ns = o.received_ns = now_ns;
    return o;
  }

  // 200 ms of a run: physics every ms, a procedure that goes on at 50 and 120 ms, and events.
  void Record() {
    std::filesystem::remove(first_);
    auto recorder = std::move(*bus::log::Recorder::Create(first_, {}));
    bus::LatestCodec<core::PhysicsState> codec;
    std::vector<std::uint8_t> bytes(2000);
    for (std::uint64_t tick = 1; tick <= kTicks; ++tick) {
      const std::int64_t now_ns = kBegin_ns + static_cast<std::int64_t>(tick) * core::kTick_ns;
      if (tick == 1 || tick == 50 || tick == 120) {
        core::LogicStatus status;
        status.step = "step_" + std::to_string(tick);
        auto o = About("logic/status", bus::TopicClass::kState, bus::MessageType::kLogicStatus, tick, now_ns);
        bus::EncodeState(status, &o.payload);
        ASSERT_TRUE(recorder->Add(o));
        oos::Event event;
        event.set_name("step_entered");
        event.set_detail(status.step);
        o = About("event", bus::TopicClass::kEvent, bus::MessageType::kEvent, tick, now_ns);
        o.payload = event.SerializeAsString();
        ASSERT_TRUE(recorder->Add(o));
      }
      const core::PhysicsState state = StateAt(tick);
      for (int part = 0; part < codec.NumParts(state, 1000); ++part) {
        auto o = About("physics/state", bus::TopicClass::kLatest, bus::MessageType::kPhysicsState, tick, now_ns);
        o.part = static_cast<unsigned>(part);
        o.num_parts = static_cast<unsigned>(codec.NumParts(state, 1000));
        const std::size_t size = codec.Encode(state, part, 1000, bytes.data(), bytes.size());
        o.payload.assign(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
        ASSERT_TRUE(recorder->Add(o));
      }
    }
    ASSERT_TRUE(recorder->Close(0, 0));
  }

  // The procedure's step, over and over at one time.
  void RecordManyStates(int num_states) {
    std::filesystem::remove(first_);
    auto recorder = std::move(*bus::log::Recorder::Create(first_, {}));
    for (int i = 1; i <= num_states; ++i) {
      core::LogicStatus status;
      status.step = "step_" + std::to_string(i);
      auto o = About("logic/status", bus::TopicClass::kState, bus::MessageType::kLogicStatus,
                     static_cast<std::uint64_t>(i), kBegin_ns);
      bus::EncodeState(status, &o.payload);
      ASSERT_TRUE(recorder->Add(o));
    }
    ASSERT_TRUE(recorder->Close(0, 0));
  }

  // Starts a session with the replay and an observer of everything; returns when both know each other.
  void Start() {
    registry_ = bus::testing::MakeRegistry();
    listener_ = bus::testing::MakeNode("listener", registry_->endpoint());
    listener_->Observe("*");
    ASSERT_TRUE(listener_->Start());
    node_ = bus::testing::MakeNode("replay", registry_->endpoint());
    auto opened = BusReplay::Open(first_);
    ASSERT_TRUE(opened) << opened.error().detail;
    replay_ = std::move(*opened);
    replay_->Declare(node_.get());
    auto knock = node_->WriteLatest<core::DeviceState>("device/knock/state");
    ASSERT_TRUE(node_->Start());
    bool is_heard = false, is_event_heard = false;
    ASSERT_TRUE(bus::testing::Until([&] {
      core::DeviceState state;
      knock.Send(state);
      bus::testing::WaitBriefly(*node_);
      bus::testing::WaitBriefly(*listener_);
      bus::Observation o;
      while (listener_->PollObservation(&o)) {
        is_heard |= o.topic == "device/knock/state";
        is_event_heard |= o.topic == "event";
      }
      if (is_heard && !is_event_heard) node_->Emit({0, "replay", "knock", ""});
      return is_heard && is_event_heard;
    }));
    // Nothing of that is on its way any more.
    ListenUntil([&, quiet = 0](bool has_heard) mutable { return (quiet = has_heard ? 0 : quiet + 1) > 20; }, nullptr);
  }

  void ListenUntil(const std::function<bool(bool)>& is_enough, bus::log::Recorder* recorder) {
    ASSERT_TRUE(bus::testing::Until([&] {
      bus::testing::WaitBriefly(*node_);
      bus::testing::WaitBriefly(*listener_);
      bus::Observation o;
      bool has_heard = false;
      while (listener_->PollObservation(&o)) {
        if (!o.topic.starts_with("physics/") && !o.topic.starts_with("logic/") && o.topic != "event") continue;
        has_heard = true;
        if (recorder != nullptr) {
          EXPECT_TRUE(recorder->Add(o));
        }
      }
      return is_enough(has_heard);
    }));
  }

  // Of STATE and EVENT; an observer has no accounts of LATEST.
  [[nodiscard]] bool AreBooksClosed() const {
    for (const bus::Node* node : {node_.get(), listener_.get()}) {
      for (const bus::Account& account : node->Accounts()) {
        if (account.topic_class != bus::TopicClass::kLatest && !account.is_settled()) return false;
      }
    }
    return true;
  }

  // Plays into a second recording by a test clock, which advances a millisecond for each poll of the observer.
  Said PlayToTheEnd(std::int64_t now_ns = 0) {
    std::filesystem::remove(second_);
    auto recorder = std::move(*bus::log::Recorder::Create(second_, {}));
    ListenUntil(
        [&](bool) {
          now_ns += core::kTick_ns;
          EXPECT_TRUE(replay_->Advance(now_ns));
          return replay_->is_over();
        },
        recorder.get());
    // Until no message arrives any more, and the accounts show that no state and no event is missing.
    ListenUntil(
        [this, quiet = 0](bool has_heard) mutable {
          quiet = has_heard ? 0 : quiet + 1;
          return quiet > 20 && AreBooksClosed();
        },
        recorder.get());
    EXPECT_TRUE(recorder->Close(0, 0));
    return Read(second_);
  }

  std::filesystem::path first_ =
      std::filesystem::path(::testing::TempDir()) / ("replay" + std::to_string(::getpid()) + ".mcap");
  std::filesystem::path second_ = first_.string() + ".again";
  std::unique_ptr<bus::Registry> registry_;
  std::unique_ptr<bus::Node> listener_, node_;
  std::unique_ptr<BusReplay> replay_;
};

TEST_F(BusReplayTest, ARecordingOfTheReplayEqualsTheRecording) {
  Start();
  EXPECT_EQ(replay_->topics(), (std::vector<std::string>{"event", "logic/status", "physics/state"}));
  ASSERT_TRUE(replay_->Seek(0.0, 0));
  const Said again = PlayToTheEnd();
  const Said once = Read(first_);
  ASSERT_EQ(once.at("physics/state").size(), kTicks);
  for (const auto& [topic, messages] : once) {
    ASSERT_EQ(again.count(topic), 1U) << topic;
    EXPECT_EQ(again.at(topic).size(), messages.size()) << topic;
    EXPECT_EQ(again.at(topic), messages) << topic;
  }
}

TEST_F(BusReplayTest, SeekPublishesTheStatesAsOfThenAndContinuesFromThere) {
  Start();
  ASSERT_TRUE(replay_->Seek(0.1, 0));
  const Said said = PlayToTheEnd();
  ASSERT_EQ(said.at("logic/status").size(), 2U);
  core::LogicStatus status;
  ASSERT_TRUE(bus::DecodeState(said.at("logic/status")[0], &status));
  EXPECT_EQ(status.step, "step_50") << "what was said at 0.05 s still holds at 0.1 s";
  ASSERT_TRUE(bus::DecodeState(said.at("logic/status")[1], &status));
  EXPECT_EQ(status.step, "step_120");
  EXPECT_EQ(said.at("event").size(), 1U) << "events are not repeated";
  EXPECT_EQ(said.at("physics/state").front(), TextOf(StateAt(101)));
  EXPECT_EQ(said.at("physics/state").size(), kTicks - 100);
}

// A reader of a state, in the order in which its values came.
class Steps {
 public:
  explicit Steps(bus::Node* node) : node_(node), status_(node->ReadState<core::LogicStatus>("logic/status")) {}
  bool WaitFor(const std::string& step, bus::Node* other) {
    return bus::testing::Until([&] {
      bus::testing::WaitBriefly(*other);
      bus::testing::WaitBriefly(*node_);
      return status_.has_value() && status_.value().step == step;
    });
  }

 private:
  bus::Node* node_;
  bus::StateReader<core::LogicStatus>& status_;
};

TEST_F(BusReplayTest, ASeekBackClearsLaterStatesAlsoForNodesThatJoinLater) {
  Start();
  ASSERT_TRUE(replay_->Seek(0.1, 0));
  ASSERT_TRUE(replay_->Advance(30'000'000));
  auto early = bus::testing::MakeNode("early", registry_->endpoint());
  Steps heard_early(early.get());
  ASSERT_TRUE(early->Start());
  EXPECT_TRUE(heard_early.WaitFor("step_120", node_.get()));
  // Nothing is played on: time stands still at the start.
  replay_->Apply({ReplayCommand::Kind::kPause}, 30'000'000);
  ASSERT_TRUE(replay_->Seek(0.0, 30'000'000));
  ASSERT_TRUE(replay_->Advance(30'000'000));
  EXPECT_TRUE(heard_early.WaitFor("", node_.get())) << "it still believes in step_120";
  auto late = bus::testing::MakeNode("late", registry_->endpoint());
  Steps heard_late(late.get());
  ASSERT_TRUE(late->Start());
  EXPECT_TRUE(heard_late.WaitFor("", node_.get())) << "whoever comes later got a value of the future";
}

TEST_F(BusReplayTest, AMessageThatTheBusDoesNotAcceptIsOfferedAgainAndThenCounted) {
  RecordManyStates(100);  // more than the way to the bus thread holds
  node_ = bus::testing::MakeNode("replay", "tcp://127.0.0.1:1");
  replay_ = std::move(*BusReplay::Open(first_));
  replay_->Declare(node_.get());  // never started: nothing empties that queue
  ASSERT_TRUE(replay_->Seek(0.0, 0));
  ASSERT_TRUE(replay_->Advance(1'000'000'000));
  const std::uint64_t taken = replay_->num_published();
  EXPECT_GT(taken, 0U);
  ASSERT_LT(taken, 100U);
  EXPECT_EQ(replay_->num_not_published(), 0U);
  ASSERT_TRUE(replay_->due_ns().has_value());
  EXPECT_EQ(*replay_->due_ns(), 1'001'000'000) << "offered again a millisecond later";
  ASSERT_TRUE(replay_->Advance(1'000'000'000 + BusReplay::kPatience_ns - 1));
  EXPECT_EQ(replay_->num_not_published(), 0U) << "it is offered again for a second";
  for (std::int64_t s = 2; !replay_->is_over() && s < 300; ++s) ASSERT_TRUE(replay_->Advance(s * 1'000'000'000));
  EXPECT_TRUE(replay_->is_over());
  EXPECT_EQ(replay_->num_published(), taken);
  EXPECT_EQ(replay_->num_not_published(), 100 - taken);
}

TEST_F(BusReplayTest, MoreStatesThanTheBusAcceptsAtOnceAllArrive) {
  RecordManyStates(100);
  Start();
  ASSERT_TRUE(replay_->Seek(0.0, 0));
  const Said said = PlayToTheEnd(1'000'000'000);
  EXPECT_EQ(replay_->num_published(), 100U);
  EXPECT_EQ(replay_->num_not_published(), 0U);
  core::LogicStatus status;
  ASSERT_TRUE(bus::DecodeState(said.at("logic/status").back(), &status));
  EXPECT_EQ(status.step, "step_100");
}

TEST_F(BusReplayTest, AMessageThatCannotBeDecodedIsNotCountedAsPublished) {
  std::filesystem::remove(first_);
  auto recorder = std::move(*bus::log::Recorder::Create(first_, {}));
  auto o = About("logic/status", bus::TopicClass::kState, bus::MessageType::kLogicStatus, 1, kBegin_ns);
  o.payload = "\xff\xff\xff";
  ASSERT_TRUE(recorder->Add(o));
  ASSERT_TRUE(recorder->Close(0, 0));
  node_ = bus::testing::MakeNode("replay", "tcp://127.0.0.1:1");
  replay_ = std::move(*BusReplay::Open(first_));
  replay_->Declare(node_.get());
  ASSERT_TRUE(replay_->Seek(0.0, 0));
  ASSERT_TRUE(replay_->Advance(1));
  EXPECT_EQ(replay_->num_published(), 0U);
  EXPECT_EQ(replay_->num_not_published(), 1U);
}

TEST_F(BusReplayTest, PausesStepsAndChangesItsSpeed) {
  Start();
  ASSERT_TRUE(replay_->Seek(0.0, 0));
  ASSERT_TRUE(replay_->Advance(10'000'000));
  const std::uint64_t published = replay_->num_published();
  EXPECT_GT(published, 10U);
  replay_->Apply({ReplayCommand::Kind::kPause}, 10'000'000);
  ASSERT_TRUE(replay_->Advance(60'000'000));
  EXPECT_EQ(replay_->num_published(), published);
  replay_->Apply({ReplayCommand::Kind::kStep, 3.0}, 60'000'000);
  ASSERT_TRUE(replay_->Advance(60'000'000));
  EXPECT_EQ(replay_->num_published(), published + 3);
  EXPECT_TRUE(replay_->is_paused());
  // Ten times as fast from here: 5 ms are 50 ms of the recording.
  const double before_s = replay_->position_s();
  replay_->Apply({ReplayCommand::Kind::kPlay}, 60'000'000);
  replay_->Apply({ReplayCommand::Kind::kSpeed, 10.0}, 60'000'000);
  ASSERT_TRUE(replay_->Advance(65'000'000));
  EXPECT_NEAR(replay_->position_s() - before_s, 0.05, 0.0011);
  ASSERT_TRUE(replay_->due_ns().has_value());
  EXPECT_LE(*replay_->due_ns(), 65'200'000);
}

TEST(ReplayCommand, IsReadFromALine) {
  EXPECT_EQ(ParseReplayCommand("pause")->kind, ReplayCommand::Kind::kPause);
  EXPECT_EQ(ParseReplayCommand("step")->value, 1.0);
  EXPECT_EQ(ParseReplayCommand("step 12")->value, 12.0);
  EXPECT_EQ(ParseReplayCommand("seek 1.5")->value, 1.5);
  EXPECT_EQ(ParseReplayCommand(" speed 0.1 ")->value, 0.1);
  for (const char* line : {"", "seek", "seek -1", "speed 0", "pause 3", "step 0", "play it", "speed 1 2"}) {
    EXPECT_FALSE(ParseReplayCommand(line)) << line;
  }
}

}  // namespace
}  // namespace oos
