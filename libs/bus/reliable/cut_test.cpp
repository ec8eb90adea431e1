#include <gtest/gtest.h>

#include <string>

#include "bus/figures.hpp"
#include "bus/testing/make_node.hpp"
#include "bus/testing/own_network.hpp"

// A reader after its connection broke, or the network was cut.
namespace bus {
namespace {

using testing::ExpectAccountsClose;
using testing::kLong_ns;
using testing::MakeNode;
using testing::MakeRegistry;
using testing::OwnNetwork;
using testing::Until;
using testing::WaitBriefly;

constexpr std::int64_t kTenth_ns = core::kNanosecondsPerSecond / 10;

class Pair {
 public:
  // With STATE, a gap makes the reader subscribe again, which repairs its events too; without, events repair
  // themselves.
  explicit Pair(bool has_state)
      : registry_(MakeRegistry()),
        writer_(MakeNode("physics_node", registry_->endpoint())),
        reader_(MakeNode("logic_node", registry_->endpoint())),
        figures_(writer_->WriteState<Figures>(FiguresTopic("physics_node"))) {
    reader_->ReadEvents();
    if (has_state) values_ = &reader_->ReadState<Figures>(FiguresTopic("physics_node"));
    EXPECT_TRUE(writer_->Start().has_value());
    EXPECT_TRUE(reader_->Start().has_value());
    // Later events are counted from the first one that arrives.
    EXPECT_TRUE(Until([&] {
      Step();
      return last_ != 0;
    }));
  }
  void Step() {
    if (writer_->Emit({0, "physics_node", "count", std::to_string(emitted_ + 1)})) ++emitted_;
    if (figures_.Set({{{"n", static_cast<double>(changed_ + 1)}}})) ++changed_;
    Poll();
  }
  void Poll() {
    WaitBriefly(*reader_);
    core::Event event;
    while (writer_->PollEvent(&event)) num_lost_ += event.name == "node_lost" ? 1 : 0;
    while (reader_->PollEvent(&event)) {
      EXPECT_NE(event.name, "events_missed");
      if (event.name != "count") continue;
      const std::uint64_t number = std::stoull(event.detail);
      if (last_ != 0) {
        EXPECT_EQ(number, last_ + 1);
      }
      last_ = number;
    }
  }
  void ExpectLastHasArrived() {
    EXPECT_TRUE(Until([&] {
      Poll();
      return last_ == emitted_ &&
             (values_ == nullptr || (values_->has_value() && *FindFigure(values_->value(), "n") == changed_));
    })) << last_
        << " of " << emitted_ << " events";
  }
  void ExpectAllIsThere() {
    ExpectLastHasArrived();
    ExpectAccountsClose({writer_.get(), reader_.get()});
  }
  void PollFor(std::int64_t duration_ns) {
    const std::int64_t end = core::MonotonicNow_ns() + duration_ns;
    while (core::MonotonicNow_ns() < end) Poll();
  }
  void Run(std::int64_t duration_ns) {
    const std::int64_t end = core::MonotonicNow_ns() + duration_ns;
    while (core::MonotonicNow_ns() < end) Step();
  }
  [[nodiscard]] unsigned writers_port() const {
    const std::string endpoint = reader_->Peers().at(0).router_endpoint;
    return static_cast<unsigned>(std::stoul(endpoint.substr(endpoint.rfind(':') + 1)));
  }
  [[nodiscard]] int num_lost() const { return num_lost_; }

 private:
  std::unique_ptr<Registry> registry_;
  std::unique_ptr<Node> writer_, reader_;
  StateWriter<Figures> figures_;
  StateReader<Figures>* values_ = nullptr;
  std::uint64_t emitted_ = 0, last_ = 0, changed_ = 0;
  int num_lost_ = 0;
};

class BrokenConnections : public ::testing::TestWithParam<bool> {};

TEST_P(BrokenConnections, LoseNothing) {
  const std::string why = OwnNetwork::Run([](OwnNetwork& network) {
    Pair pair(GetParam());
    for (int i = 0; i < 5; ++i) {
      ASSERT_TRUE(network.BreakConnections());
      pair.Run(kTenth_ns);
      ASSERT_TRUE(network.Mend());
      pair.Run(kTenth_ns);
    }
    pair.ExpectAllIsThere();
  });
  if (!why.empty()) GTEST_SKIP() << why;
}

INSTANTIATE_TEST_SUITE_P(Cut, BrokenConnections, ::testing::Bool(),
                         [](const auto& with) { return with.param ? "OfStateAndEvents" : "OfEventsAlone"; });

// The event arrives; its acknowledgement does not, and is lost with the connection.
TEST(Cut, ALostAcknowledgementIsRequestedAgain) {
  const std::string why = OwnNetwork::Run([](OwnNetwork& network) {
    Pair pair(false);
    pair.ExpectAllIsThere();
    ASSERT_TRUE(network.DropWordsTo(pair.writers_port()));
    pair.Step();
    pair.ExpectLastHasArrived();
    ASSERT_TRUE(network.BreakConnections());
    pair.PollFor(10 * kTenth_ns);  // TCP tries again by then, and is refused
    ASSERT_TRUE(network.Mend());
    pair.ExpectAllIsThere();
  });
  if (!why.empty()) GTEST_SKIP() << why;
}

TEST(Cut, AReaderDeclaredDeadByMistakeResumesWhereItStopped) {
  const std::string why = OwnNetwork::Run([](OwnNetwork& network) {
    Pair pair(true);
    ASSERT_TRUE(network.Cut());
    pair.Run(3 * kTenth_ns);
    ASSERT_TRUE(Until([&] {  // emits nothing more: the log must not overflow, however long this takes
      pair.Poll();
      return pair.num_lost() == 1;
    }));
    ASSERT_TRUE(network.Mend());
    pair.ExpectAllIsThere();
  });
  if (!why.empty()) GTEST_SKIP() << why;
}

}  // namespace
}  // namespace bus
