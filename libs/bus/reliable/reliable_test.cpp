#include <gtest/gtest.h>

#include <atomic>
#include <random>
#include <string>
#include <thread>
#include <zmq.hpp>

#include "bus/figures.hpp"
#include "bus/testing/make_node.hpp"
#include "bus/wire/control.hpp"
#include "proto/bus.pb.h"

// STATE, EVENT and SERVICE: every message arrives, or both ends count it as dropped.
namespace bus {
namespace {

using testing::ExpectAccountsClose;
using testing::kLong_ns;
using testing::MakeNode;
using testing::MakeRegistry;
using testing::Until;
using testing::WaitBriefly;

Account AccountOf(const Node& node, const std::string& topic, const std::string& peer, bool is_writer) {
  Account sum;
  for (const Account& account : node.Accounts()) {
    if (account.topic == topic && account.peer == peer && account.is_writer == is_writer) {
      sum.sent += account.sent;
      sum.received += account.received;
      for (std::size_t i = 0; i < kNumDropReasons; ++i) sum.dropped[i] += account.dropped[i];
    }
  }
  return sum;
}

// Takes events until none has come for as long as a heartbeat takes; checks that "count" events come in order.
struct CountReader {
  void Take(Node& node) {
    core::Event event;
    while (node.PollEvent(&event)) {
      if (event.name == "events_missed") missed += std::stoull(event.detail.substr(event.detail.find(": ") + 2));
      if (event.name != "count") continue;
      const std::uint64_t number = std::stoull(event.detail);
      EXPECT_GE(number, next) << "an event came twice, or out of order";
      if (number != next) ++gaps;
      next = number + 1;
      ++taken;
    }
  }
  std::uint64_t next = 1, taken = 0, gaps = 0, missed = 0;
};

bool EmitCount(Node& node, std::uint64_t* number) {
  if (!node.Emit({0, node.name(), "count", std::to_string(*number + 1)})) return false;
  ++*number;
  return true;
}

class OneWriterOneReader : public ::testing::Test {
 protected:
  void SetUp() override {
    registry_ = MakeRegistry();
    writer_ = MakeNode("physics_node", registry_->endpoint());
    status_ = writer_->WriteState<core::LogicStatus>(kLogicStatusTopic);
    figures_ = writer_->WriteState<Figures>(FiguresTopic("physics_node"));
    ASSERT_TRUE(writer_->Start().has_value());
    StartReader();
  }
  void StartReader(bool sends_goodbye = true) {
    reader_ = MakeNode("logic_node", registry_->endpoint(), sends_goodbye);
    reader_->ReadEvents();
    values_ = &reader_->ReadState<Figures>(FiguresTopic("physics_node"));
    ASSERT_TRUE(reader_->Start(kLong_ns).has_value());
    ASSERT_TRUE(Until([&] {
      WaitBriefly(*reader_);
      WaitBriefly(*writer_);
      return IsSubscribed();
    }));
  }
  // Both ends have opened the account of this reader.
  bool IsSubscribed() const {
    for (const Account& account : writer_->Accounts()) {
      if (account.topic == kEventTopic && account.peer_instance == reader_->instance()) {
        for (const Account& other : reader_->Accounts()) {
          if (other.topic == kEventTopic && other.peer_instance == writer_->instance()) return true;
        }
      }
    }
    return false;
  }
  std::unique_ptr<Registry> registry_;
  std::unique_ptr<Node> writer_, reader_;
  StateWriter<core::LogicStatus> status_;
  StateWriter<Figures> figures_;
  StateReader<Figures>* values_ = nullptr;
};

TEST_F(OneWriterOneReader, EveryEventAndChangeIsInBothAccounts) {
  std::uint64_t emitted = 0;
  CountReader count;
  int changes = 0;
  ASSERT_TRUE(Until([&] {
    if (emitted < 5'000) EmitCount(*writer_, &emitted);
    if (changes < 500 && figures_.Set({{{"n", static_cast<double>(changes + 1)}}}, changes % 2 == 0 ? "a" : "b")) {
      ++changes;
    }
    reader_->Poll();
    count.Take(*reader_);
    return emitted == 5'000 && changes == 500 && count.taken == 5'000;
  }));
  EXPECT_EQ(count.gaps, 0u);
  ExpectAccountsClose({writer_.get(), reader_.get()});
  const Account events = AccountOf(*writer_, kEventTopic, "logic_node", true);
  EXPECT_EQ(events.sent, 5'000u);
  EXPECT_EQ(events.received, 5'000u);
  const Account figures = AccountOf(*reader_, FiguresTopic("physics_node"), "physics_node", false);
  EXPECT_EQ(figures.sent, 500u);
  EXPECT_EQ(figures.received + figures.dropped_for(DropReason::kSuperseded), 500u);
  EXPECT_EQ(*FindFigure(values_->values().at("b"), "n"), 500.0);
  // Observers see it too.
  EXPECT_TRUE(Until([&] {
    WaitBriefly(*writer_);
    for (const PeerStatus& peer : writer_->Peers()) {
      for (const ReportedAccount& account : peer.accounts) {
        if (account.topic == kEventTopic && account.peer == "physics_node" && !account.is_writer &&
            account.received == 5'000) {
          return true;
        }
      }
    }
    return false;
  }));
}

// A snapshot is sorted by key, but a late joiner must read the changes in the order of time.
TEST_F(OneWriterOneReader, ALateReadersNewestValueIsTheOneThatWasSetLast) {
  reader_.reset();
  figures_.Set({{{"n", 1.0}}}, "z");
  figures_.Set({{{"n", 2.0}}}, "a");
  StartReader();
  ASSERT_TRUE(Until([&] {
    WaitBriefly(*reader_);
    WaitBriefly(*writer_);
    return values_->values().size() == 2;
  }));
  EXPECT_EQ(*FindFigure(values_->value(), "n"), 2.0);
  EXPECT_EQ(values_->version(), 2u);
  ExpectAccountsClose({writer_.get(), reader_.get()});
}

// Its bus thread lives, so it seems alive from outside; but its step thread does not take events.
TEST_F(OneWriterOneReader, AHungReaderIsEvictedByNameAndLearnsExactlyWhatItMissed) {
  std::uint64_t emitted = 0;
  bool is_named = false;
  ASSERT_TRUE(Until([&] {
    for (int i = 0; i < 200; ++i) EmitCount(*writer_, &emitted);
    WaitBriefly(*writer_);
    core::Event event;
    while (writer_->PollEvent(&event)) {
      is_named = is_named || (event.name == "peer_evicted" && event.detail == "logic_node");
    }
    return is_named;
  }));
  // From now on it delays nobody.
  const std::uint64_t before = emitted;
  ASSERT_TRUE(Until([&] {
    EmitCount(*writer_, &emitted);
    return emitted >= before + 6'000;
  }));
  CountReader count;
  ASSERT_TRUE(Until([&] {
    WaitBriefly(*reader_);
    count.Take(*reader_);
    return count.next == emitted + 1;
  })) << count.next
      << " of " << emitted;
  EXPECT_GE(count.gaps, 1u);  // on a slow machine it may be back and fall behind once more
  EXPECT_GT(count.missed, 0u);
  ExpectAccountsClose({writer_.get(), reader_.get()});
  const Account events = AccountOf(*reader_, kEventTopic, "physics_node", false);
  EXPECT_EQ(events.dropped_for(DropReason::kOverrun), count.missed);
  // "peer_evicted" is one of the writer's events too.
  EXPECT_EQ(count.taken + count.missed, emitted + (events.sent - emitted) - (events.received - count.taken));
}

TEST_F(OneWriterOneReader, AReaderThatRestartsGoesOnWithANewAccount) {
  std::uint64_t emitted = 0;
  for (const bool sends_goodbye : {true, false, true}) {
    CountReader count;
    count.next = emitted + 1;
    const std::uint64_t first = emitted;
    ASSERT_TRUE(Until([&] {
      EmitCount(*writer_, &emitted);
      WaitBriefly(*reader_);
      count.Take(*reader_);
      return count.taken >= 20;
    }));
    EXPECT_EQ(count.gaps, 0u);
    EXPECT_GE(emitted, first + 20);
    reader_.reset();
    EmitCount(*writer_, &emitted);  // to nobody, or to one that is dead
    StartReader(sends_goodbye);
    ExpectAccountsClose({writer_.get(), reader_.get()});
  }
  const Account events = AccountOf(*writer_, kEventTopic, "logic_node", true);
  EXPECT_TRUE(events.is_settled());
  EXPECT_GE(events.received, 60u);
}

TEST_F(OneWriterOneReader, AWriterThatRestartsIsReadFromItsFirstStateOn) {
  ASSERT_TRUE(figures_.Set({{{"n", 1.0}}}, "old"));
  ASSERT_TRUE(Until([&] {
    WaitBriefly(*reader_);
    return values_->values().count("old") == 1;
  }));
  for (const bool sends_goodbye : {true, false}) {
    writer_.reset();
    writer_ = MakeNode("physics_node", registry_->endpoint(), sends_goodbye);
    figures_ = writer_->WriteState<Figures>(FiguresTopic("physics_node"));
    ASSERT_TRUE(writer_->Start(kLong_ns).has_value());
    ASSERT_TRUE(figures_.Set({{{"n", 2.0}}}, "new"));
    ASSERT_TRUE(Until([&] {
      WaitBriefly(*reader_);
      return values_->values().count("new") == 1 && IsSubscribed();
    }));
    EXPECT_EQ(values_->values().size(), 1u) << "values of the writer's earlier life are void";
    std::uint64_t emitted = 0;
    CountReader count;
    ASSERT_TRUE(Until([&] {
      EmitCount(*writer_, &emitted);
      WaitBriefly(*reader_);
      core::Event event;
      while (reader_->PollEvent(&event)) count.taken += event.name == "count" ? 1 : 0;
      return count.taken > 10;
    }));
    ExpectAccountsClose({writer_.get(), reader_.get()});
  }
}

// --- SERVICE

// A caller without a node, which can repeat requests and make late ones.
class RawCaller {
 public:
  RawCaller(const std::string& endpoint, std::uint64_t session) : identity_{session, TopicId("caller"), 1} {
    socket_.set(zmq::sockopt::routing_id, "caller#1");
    socket_.set(zmq::sockopt::linger, 0);
    socket_.connect(endpoint);
  }
  void Request(std::uint64_t request, double value, std::int64_t time_left_ns) {
    oos::Control control;
    oos::ParameterRequest* sent_request = control.mutable_parameter_request();
    sent_request->set_request(request);
    sent_request->set_caller("caller");
    sent_request->set_caller_instance(1);
    sent_request->set_time_left_ns(time_left_ns);
    sent_request->mutable_change()->set_name("gain");
    sent_request->mutable_change()->set_value(value);
    const auto bytes = detail::EncodeControl(identity_, TopicClass::kService, control);
    socket_.send(zmq::buffer(bytes), zmq::send_flags::none);
  }
  bool TakeReply(oos::ParameterReply* reply) {
    zmq::message_t message;
    if (!socket_.recv(message, zmq::recv_flags::dontwait)) return false;
    oos::Control control;
    EXPECT_TRUE(detail::DecodeControl({message.data<std::uint8_t>(), message.size()}, identity_.session, &control));
    *reply = control.parameter_reply();
    return true;
  }

 private:
  detail::Identity identity_;
  zmq::context_t context_{1};
  zmq::socket_t socket_{context_, zmq::socket_type::dealer};
};

class Service : public ::testing::Test {
 protected:
  void SetUp() override {
    registry_ = MakeRegistry();
    owner_ = MakeNode("physics_node", registry_->endpoint());
    owner_->OwnParameters({"gain"});
    ASSERT_TRUE(owner_->Start().has_value());
    other_ = MakeNode("logic_node", registry_->endpoint());
    ASSERT_TRUE(other_->Start().has_value());
    ASSERT_TRUE(other_->WaitForPeers({"physics_node"}, kLong_ns).has_value());
    caller_ = std::make_unique<RawCaller>(other_->Peers()[0].router_endpoint, owner_->session());
  }
  bool Apply() {
    core::ParameterChange change;
    std::uint64_t ticket = 0;
    if (!owner_->PollParameter(&change, &ticket)) return false;
    value_ += change.value;
    owner_->AckParameter(ticket, ++tick_, true);
    return true;
  }
  std::unique_ptr<Registry> registry_;
  std::unique_ptr<Node> owner_, other_;
  std::unique_ptr<RawCaller> caller_;
  double value_ = 0.0;
  std::uint64_t tick_ = 100;
};

TEST_F(Service, ARepeatedRequestIsAnsweredFromMemoryAndAppliedOnce) {
  oos::ParameterReply first, again;
  caller_->Request(1, 2.5, kLong_ns);
  caller_->Request(1, 2.5, kLong_ns);  // before it is applied
  ASSERT_TRUE(Until([&] {
    WaitBriefly(*owner_);
    Apply();
    return caller_->TakeReply(&first);
  }));
  caller_->Request(1, 2.5, kLong_ns);  // after
  ASSERT_TRUE(Until([&] {
    WaitBriefly(*owner_);
    Apply();
    return caller_->TakeReply(&again);
  }));
  EXPECT_EQ(value_, 2.5);
  EXPECT_TRUE(first.is_accepted());
  EXPECT_EQ(first.SerializeAsString(), again.SerializeAsString());
  caller_->Request(2, 1.0, kLong_ns);  // another request
  ASSERT_TRUE(Until([&] {
    WaitBriefly(*owner_);
    Apply();
    return caller_->TakeReply(&again);
  }));
  EXPECT_EQ(value_, 3.5);
}

TEST_F(Service, ARequestAfterTheCallersDeadlineIsNotApplied) {
  oos::ParameterReply reply;
  caller_->Request(1, 2.5, 1);  // 1 ns left
  ASSERT_TRUE(Until([&] {
    WaitBriefly(*owner_);
    Apply();
    return caller_->TakeReply(&reply);
  }));
  EXPECT_EQ(value_, 0.0);
  EXPECT_FALSE(reply.is_accepted());
  EXPECT_NE(reply.why().find("too late"), std::string::npos) << reply.why();
}

TEST_F(Service, CallsAreInBothAccounts) {
  std::atomic<bool> is_done{false};
  std::thread step([&] {
    while (!is_done.load()) {
      WaitBriefly(*owner_);
      while (Apply()) {
      }
    }
  });
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(other_->SetParameter("physics_node", {"gain", 1.0}).has_value());
  EXPECT_FALSE(other_->SetParameter("physics_node", {"gian", 1.0}).has_value());
  is_done.store(true);
  step.join();
  // Nobody applies this one.
  EXPECT_FALSE(other_->SetParameter("physics_node", {"gain", 1.0}, core::kNanosecondsPerSecond / 5).has_value());
  EXPECT_EQ(value_, 20.0);
  const Account sent_request = AccountOf(*other_, kParameterTopic, "physics_node", true);
  EXPECT_EQ(sent_request.sent, 22u);
  EXPECT_EQ(sent_request.received, 21u);
  EXPECT_EQ(sent_request.dropped_for(DropReason::kUnanswered), 1u);
  EXPECT_EQ(AccountOf(*owner_, kParameterTopic, "logic_node", false).received, 22u);
}

}  // namespace
}  // namespace bus
