#include "bus/accounts/reported_accounts.hpp"

#include <gtest/gtest.h>

#include "bus/testing/make_node.hpp"

namespace bus {
namespace {

constexpr std::int64_t kLater_ns = ReportedAccounts::kCompareAfter_ns;

// One writer and one reader, as their heartbeats show them to an observer.
class TwoEnds {
 public:
  // Both report at this time of the observer's clock.
  void Report(ReportedAccounts* joined, std::int64_t now_ns, std::uint64_t sent, std::uint64_t known) {
    writer_.accounts = {{kPhysicsStateTopic, "haptic_node", true, sent, 0, 0, sent, 2, now_ns}};
    reader_.accounts = {{kPhysicsStateTopic, "physics_node", false, known, known, 0, known, 1, now_ns}};
    joined->Update({writer_, reader_});
  }
  PeerStatus writer_ = Make("physics_node", 1), reader_ = Make("haptic_node", 2);

 private:
  static PeerStatus Make(const std::string& name, std::uint64_t instance) {
    PeerStatus peer;
    peer.name = name;
    peer.instance = instance;
    peer.is_alive = true;
    return peer;
  }
};

TEST(ReportedAccounts, MessagesOnTheWayAreNoDisagreement) {
  TwoEnds ends;
  ReportedAccounts joined;
  ends.Report(&joined, 1, 1000, 400);
  EXPECT_EQ(joined.num_compared(), 0u);
  ends.Report(&joined, 1 + kLater_ns / 2, 1500, 900);  // too soon to compare
  EXPECT_EQ(joined.num_compared(), 0u);
  ends.Report(&joined, 1 + kLater_ns, 2000, 1000);
  EXPECT_EQ(joined.num_compared(), 1u);
  EXPECT_TRUE(joined.Disagreements().empty());
}

TEST(ReportedAccounts, FindsAReaderThatMissesMessages) {
  TwoEnds ends;
  ReportedAccounts joined;
  ends.Report(&joined, 1, 1000, 400);
  ends.Report(&joined, 1 + kLater_ns, 2000, 999);
  ASSERT_EQ(joined.Disagreements().size(), 1u);
  EXPECT_EQ(joined.Disagreements()[0],
            "physics/state from physics_node to haptic_node: 1000 had been sent, and later its reader knows of 999");
  ends.Report(&joined, 1 + 2 * kLater_ns, 3000, 2000);
  EXPECT_TRUE(joined.Disagreements().empty());
}

TEST(ReportedAccounts, FindsAReaderThatCountsMoreThanWasSent) {
  TwoEnds ends;
  ReportedAccounts joined;
  ends.Report(&joined, 1, 1000, 1501);
  ends.Report(&joined, 1 + kLater_ns, 1500, 2500);
  ASSERT_EQ(joined.Disagreements().size(), 1u);
  EXPECT_EQ(joined.Disagreements()[0],
            "physics/state from physics_node to haptic_node: its reader had counted 1501, and later only 1500 were "
            "sent");
}

TEST(ReportedAccounts, OtherLivesAreNotCompared) {
  TwoEnds ends;
  ReportedAccounts joined;
  ends.Report(&joined, 1, 1000, 1000);
  ends.writer_.instance = 7;  // its reader has not met it yet
  ends.Report(&joined, 1 + kLater_ns, 5, 1000);
  EXPECT_EQ(joined.num_compared(), 0u);
  ends.writer_.instance = 1;
  ends.reader_.is_alive = false;
  ends.Report(&joined, 1 + 2 * kLater_ns, 5, 1000);
  EXPECT_EQ(joined.num_compared(), 0u);
  EXPECT_TRUE(joined.Disagreements().empty());
}

// Three nodes exchange messages of every class; a fourth observes them.
TEST(ReportedAccounts, BothEndsOfLivingNodesAgree) {
  const auto registry = testing::MakeRegistry();
  auto writer = testing::MakeNode("physics_node", registry->endpoint());
  auto reader = testing::MakeNode("haptic_node", registry->endpoint());
  auto watcher = testing::MakeNode("watcher", registry->endpoint());
  auto latest = writer->WriteLatest<core::PhysicsState>(kPhysicsStateTopic);
  auto state = writer->WriteState<Figures>(FiguresTopic("physics_node"));
  reader->ReadLatest<core::PhysicsState>(kPhysicsStateTopic);
  reader->ReadState<Figures>(FiguresTopic("physics_node"));
  reader->ReadEvents();
  for (Node* node : {writer.get(), reader.get(), watcher.get()}) ASSERT_TRUE(node->Start().has_value());
  ASSERT_TRUE(testing::Until([&] { return latest.has_subscribers(); }));
  for (int i = 0; i < 50; ++i) {
    core::PhysicsState message;
    latest.Send(message);
    EXPECT_TRUE(state.Set({{{"n", static_cast<double>(i)}}}));
    EXPECT_TRUE(writer->Emit({0, "physics_node", "count", ""}));
  }
  // Nothing more is sent, so the ends have to agree exactly.
  ReportedAccounts joined;
  EXPECT_TRUE(testing::Until([&] {
    testing::WaitBriefly(*reader);
    core::Event event;
    while (reader->PollEvent(&event)) {
    }
    joined.Update(watcher->Peers());
    return joined.num_compared() >= 3;  // one of each class
  }));
  EXPECT_EQ(joined.Disagreements(), std::vector<std::string>());
  testing::ExpectAccountsClose({writer.get(), reader.get()});
}

}  // namespace
}  // namespace bus
