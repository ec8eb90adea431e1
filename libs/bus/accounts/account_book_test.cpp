#include "bus/accounts/account_book.hpp"

#include <gtest/gtest.h>

#include "bus/accounts/accounts.hpp"
#include "bus/reliable/event_log.hpp"
#include "bus/testing/make_node.hpp"

namespace bus::detail {
namespace {

Account& OpenEvents(AccountBook& book, std::uint64_t instance, std::uint64_t start = 0) {
  return book.Open(kEventTopic, TopicClass::kEvent, "logic_node", instance, true, start);
}

TEST(AccountBook, UnsettledMessagesOfAGonePeerCountAsDroppedUntilItReturns) {
  AccountBook book;
  Account& events = OpenEvents(book, 1, 10);
  events.sent = 5;
  events.received = 3;
  EXPECT_FALSE(book.All()[0].is_settled());
  book.CloseAll(1);
  EXPECT_TRUE(book.All()[0].is_settled());
  EXPECT_EQ(book.All()[0].dropped_for(DropReason::kReaderGone), 2u);
  events.received = 4;  // an acknowledgement that was on its way
  EXPECT_EQ(book.All()[0].dropped_for(DropReason::kReaderGone), 1u);
  EXPECT_EQ(&OpenEvents(book, 1, 99), &events);
  EXPECT_EQ(events.start, 10u);
  EXPECT_EQ(book.All()[0].dropped_in_all(), 0u);
  EXPECT_EQ(Describe(events), "event to logic_node: sent 5 != received 4");
}

TEST(AccountBook, SumsStayExactWhenManyReadersHaveComeAndGone) {
  AccountBook book;
  std::uint64_t sent = 0, received = 0;
  for (std::uint64_t instance = 1; instance <= 2'000; ++instance) {
    Account& events = OpenEvents(book, instance);
    sent += events.sent = instance;
    received += events.received = instance / 2;
    if (instance % 3 == 0) {  // away for a while
      book.CloseAll(instance);
      OpenEvents(book, instance);
    }
    book.CloseAll(instance);
  }
  const Account total = book.Total(kEventTopic, true);
  EXPECT_EQ(total.sent, sent);
  EXPECT_EQ(total.received, received);
  EXPECT_EQ(total.dropped_for(DropReason::kReaderGone), sent - received);
  EXPECT_LT(book.All().size(), 600u);
  EXPECT_EQ(MergeByName(book.All()).size(), 2u);  // the last ones by name, and the earlier ones
}

TEST(AccountBook, AnAccountThatClosesAgainIsFoldedLast) {
  AccountBook book;
  OpenEvents(book, 1, 10);
  book.CloseAll(1);
  OpenEvents(book, 1);
  for (std::uint64_t instance = 2; instance <= 600; ++instance) {
    OpenEvents(book, instance);
    book.CloseAll(instance);
    if (instance == 500) book.CloseAll(1);
  }
  EXPECT_EQ(OpenEvents(book, 1, 99).start, 10u);  // the same account
}

// Both ends of one LATEST topic: 10 were sent, 7 came, one of them as a copy, and 3 did not.
testing::Books BothEnds() {
  Account written;
  written.topic = kPhysicsStateTopic;
  written.topic_class = TopicClass::kLatest;
  Account read = written;
  written.is_writer = true;
  written.peer = "haptic_node";
  written.peer_instance = 2;
  written.sent = 10;
  written.life = {1, 9, 1, 10};
  read.peer = "physics_node";
  read.peer_instance = 1;
  read.sent = 10;
  read.received = 7;
  read.dropped[static_cast<std::size_t>(DropReason::kLost)] = 3;
  read.life = {1, 9, 1, 10, 6, 1, 3};
  return {{"physics_node", {1, {written}}}, {"haptic_node", {2, {read}}}};
}

TEST(OpenAccounts, FindsALatestReaderThatMiscountsThoughItsOwnAccountCloses) {
  EXPECT_EQ(testing::OpenAccounts(BothEnds()), std::vector<std::string>());
  testing::Books books = BothEnds();
  Account& read = books["haptic_node"].accounts[0];
  read.sent = read.received = 13;  // each twice
  read.dropped = {};
  read.life.received = 12;
  read.life.lost = 0;
  EXPECT_TRUE(read.is_settled());
  EXPECT_EQ(testing::OpenAccounts(books).size(), 1u);
  books = BothEnds();
  books["haptic_node"].accounts[0].life.lost = 2;  // one is forgotten
  EXPECT_EQ(testing::OpenAccounts(books).size(), 1u);
}

TEST(OpenAccounts, TheLastMessagesOfALatestWriterAreWaitedFor) {
  testing::Books books = BothEnds();
  books["physics_node"].accounts[0].life.last = 11;
  EXPECT_EQ(testing::OpenAccounts(books).size(), 1u);
  books = BothEnds();
  books["haptic_node"].accounts[0].life.on_the_way = 1;
  EXPECT_EQ(testing::OpenAccounts(books).size(), 1u);
  books["haptic_node"].accounts.clear();
  EXPECT_EQ(testing::OpenAccounts(books).size(), 1u);
}

TEST(EventLog, KeepsTheNewestByNumber) {
  EventLog log;
  EXPECT_EQ(log.newest(), 0u);
  EXPECT_EQ(log.oldest(), 1u);
  for (std::uint64_t i = 1; i <= 3 * EventLog::kKept / 2; ++i) log.Append({static_cast<std::uint8_t>(i % 251)});
  EXPECT_EQ(log.newest(), 3 * EventLog::kKept / 2);
  EXPECT_EQ(log.newest() - log.oldest() + 1, EventLog::kKept);
  for (std::uint64_t i = log.oldest(); i <= log.newest(); ++i) ASSERT_EQ(log.At(i)[0], i % 251);
}

}  // namespace
}  // namespace bus::detail
