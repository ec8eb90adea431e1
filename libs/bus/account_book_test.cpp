#include "bus/detail/account_book.hpp"

#include <gtest/gtest.h>

#include "bus/detail/accounts.hpp"
#include "bus/detail/event_log.hpp"

namespace bus::detail {
namespace {

Account& OpenEvents(AccountBook& book, std::uint64_t instance, std::uint64_t start = 0) {
  return book.Open(kEventTopic, TopicClass::kEvent, "logic_node", instance, true, start);
}

TEST(AccountBook, WhatIsOnItsWayWhenAPeerGoesIsDroppedAndOpenAgainWhenItReturns) {
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

TEST(AccountBook, APeerThatJustWentIsNotFoldedForHavingBeenAwayBefore) {
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
