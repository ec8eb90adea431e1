// LATEST without nodes: a writer's end, a reader's end, and a network simulated by the test in simulated time.

#include "bus/latest/latest.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <vector>

#include "bus/latest/history.hpp"
#include "bus/latest/latest_io.hpp"
#include "bus/latest/sequence_tracker.hpp"
#include "core/clock.hpp"

namespace bus::detail {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint64_t kSession = 7;
constexpr std::uint64_t kWriter = 11, kReader = 12;  // instances

class Link {
 public:
  explicit Link(bool is_sealed = true, std::size_t history = 8)
      : writer_guard_(kSession, is_sealed), reader_guard_(kSession, is_sealed) {
    sockaddr_in address{};
    EXPECT_TRUE(ParseEndpoint(wire_.endpoint(), &address));
    sender.socket = &wire_;
    sender.guard = &writer_guard_;
    sender.envelope.session = kSession;
    sender.envelope.node = 5;
    sender.envelope.boot = 9;
    if (history != 0) receiver.reader.KeepHistory(history);
    Subscribers readers;
    readers.push_back({address, kReader, 0, history != 0});
    sender.SetReaders(readers);
    const SessionKey key{1, 2, 3};
    writer_guard_.SetSessionKey(key, kWriter);
    reader_guard_.SetSessionKey(key, kReader);
    KnownSenders senders;
    senders.push_back(reader_guard_.Know(5, kWriter));
    reader_guard_.SetSenders(senders);
  }

  Bytes Send() {
    core::HapticProxy proxy;
    proxy.cycle = sender.sequence + 1;
    proxy.header.direct = trace;
    EXPECT_EQ(sender.Send(&proxy), 1);
    Bytes bytes(2 * kMaxDatagramBytes);
    const ssize_t size = recv(wire_.fd(), bytes.data(), bytes.size(), MSG_DONTWAIT);  // loopback has it already
    EXPECT_GT(size, 0);
    bytes.resize(static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
    return bytes;
  }

  Refusal Deliver(Bytes bytes, std::int64_t now_ns = 0) {
    Envelope envelope;
    std::span<const std::uint8_t> payload;
    reader_guard_.TakeSenders();
    const Refusal refusal = reader_guard_.OpenData(bytes, &envelope, &payload);
    return refusal == Refusal::kNone ? receiver.Take(envelope, payload, now_ns) : refusal;
  }

  // The writer's report, as two heartbeats bring it.
  void ReportSpan() {
    for (int i = 0; i < 2; ++i) receiver.TakeReport(sender.envelope.boot, sender.spans[0].first, sender.spans[0].last);
  }

  // Sent to the reader, and neither here nor known to be lost.
  std::uint64_t OnTheWay() const {
    const LatestCounts counts = receiver.Counts();
    return counts.meant - counts.received - counts.restored - counts.dropped;
  }

  TypedSender<core::HapticProxy> sender{"haptic/right/proxy"};
  TypedReceiver<core::HapticProxy> receiver{"haptic/right/proxy", 10 * core::kMillisecond_ns};
  core::Trace trace;

 private:
  UdpSocket wire_ = std::move(*UdpSocket::Bind("127.0.0.1"));
  DatagramGuard writer_guard_, reader_guard_;
};

TEST(SequenceTracker, PutsEveryMessageIntoExactlyOneAccount) {
  std::mt19937_64 random(5);
  for (int round = 0; round < 200; ++round) {
    SequenceTracker tracker;
    std::map<std::uint64_t, char> fate;  // r: received, p: restored
    std::uint64_t first = 0, newest = 0, late = 0, again = 0, next = 1 + random() % 100;
    for (int i = 0; i < 500; ++i) {
      const bool goes_back = newest != 0 && random() % 3 == 0;
      const std::uint64_t sequence = goes_back ? newest - std::min(newest - 1, random() % 90) : next;
      if (!goes_back) next += 1 + (random() % 4 == 0 ? random() % 70 : 0);
      const bool is_known = newest != 0 && sequence + 64 > newest;
      if (goes_back && random() % 2 == 0) {
        const bool can = is_known && sequence >= first && fate.count(sequence) == 0;
        ASSERT_EQ(tracker.IsMissing(sequence), can);
        if (can) {
          tracker.Restore(sequence);
          fate[sequence] = 'p';
        }
        continue;
      }
      const auto verdict = tracker.Take(sequence);
      if (sequence > newest) {
        ASSERT_EQ(verdict, SequenceTracker::Verdict::kNew);
        if (newest == 0) first = sequence;
        newest = sequence;
        fate[sequence] = 'r';
      } else if (sequence < first || (is_known && fate.count(sequence) != 0)) {
        ASSERT_EQ(verdict, SequenceTracker::Verdict::kRepeated);
        ++again;
      } else if (is_known) {
        ASSERT_EQ(verdict, SequenceTracker::Verdict::kLate);
        fate[sequence] = 'r';
        ++late;
      } else {
        ASSERT_EQ(verdict, SequenceTracker::Verdict::kTooLate);
        ++late;
      }
    }
    const auto count = [&fate](char what) {
      return static_cast<std::uint64_t>(
          std::count_if(fate.begin(), fate.end(), [what](const auto& item) { return item.second == what; }));
    };
    EXPECT_EQ(tracker.received(), count('r'));
    EXPECT_EQ(tracker.restored(), count('p'));
    EXPECT_EQ(tracker.reordered(), late);
    EXPECT_EQ(tracker.repeated(), again);
    EXPECT_EQ(tracker.lost(), newest - first + 1 - fate.size());
  }
}

TEST(Latest, HistoryRestoresUpToTwoConsecutiveLosses) {
  Link link;
  link.trace.id = core::MakeTraceId(0, 1);
  link.trace.Add(core::Stage::kDeviceSend, 5);
  const std::set<std::uint64_t> lost = {3, 6, 7, 10, 11, 12};
  for (std::uint64_t sequence = 1; sequence <= 14; ++sequence) {
    const Bytes bytes = link.Send();
    if (lost.count(sequence) == 0) {
      EXPECT_EQ(link.Deliver(bytes), Refusal::kNone);
    }
    EXPECT_LE(bytes.size(), kMaxDatagramBytes);
    if (sequence == 8) {
      for (std::uint64_t i = 1; i <= 8; ++i) {
        const core::HapticProxy* sample = link.receiver.reader.Sample(i);
        ASSERT_NE(sample, nullptr) << i;
        EXPECT_EQ(sample->cycle, i);
        EXPECT_EQ(sample->header.direct.id, link.trace.id);
        EXPECT_EQ(sample->header.direct.stamps.size(), 1u);
        EXPECT_GT(sample->header.publish_ns, 0);
      }
    }
  }
  EXPECT_EQ(link.receiver.reader.Sample(10), nullptr);  // three in a row: one is lost
  EXPECT_NE(link.receiver.reader.Sample(11), nullptr);
  EXPECT_EQ(link.receiver.reader.Sample(6), nullptr);  // not kept any more
  const LatestCounts counts = link.receiver.Counts();
  EXPECT_EQ(counts.received, 8u);
  EXPECT_EQ(counts.restored, 5u);
  EXPECT_EQ(counts.dropped, 1u);
  EXPECT_EQ(link.receiver.reader.value().cycle, 14u);
}

TEST(Latest, EarlierSamplesAreSentOnlyOnRequestAndWithinTheDatagram) {
  Link without(true, 0);
  Link with;
  const std::size_t size = without.Send().size();
  EXPECT_EQ(with.Send().size(), size);  // there is none yet
  EXPECT_EQ(without.Send().size(), size);
  EXPECT_GT(with.Send().size(), size);
  with.trace.id = core::MakeTraceId(0, 1);
  for (std::size_t i = 0; i < core::kMaxStamps; ++i) with.trace.Add(core::Stage::kDeviceSend, 5);
  for (int i = 0; i < 4; ++i) EXPECT_LE(with.Send().size(), kMaxDatagramBytes);
}

TEST(Latest, AccountsCloseUnderLossDuplicationAndReordering) {
  for (const std::size_t history : {std::size_t{0}, std::size_t{8}}) {
    std::mt19937_64 random(17);
    Link link(true, history);
    std::vector<Bytes> on_their_way;
    std::uint64_t duplicates = 0, delivered = 0;
    constexpr std::uint64_t kMessages = 20'000;
    const auto deliver = [&](std::size_t i) {
      const Refusal refusal = link.Deliver(on_their_way[i]);
      ASSERT_TRUE(refusal == Refusal::kNone || refusal == Refusal::kReplayed);
      refusal == Refusal::kNone ? ++delivered : ++duplicates;
    };
    for (std::uint64_t i = 0; i < kMessages; ++i) {
      on_their_way.push_back(link.Send());
      if (random() % 100 < 5) on_their_way.pop_back();  // lost
      while (on_their_way.size() > random() % 4) {
        const std::size_t which = random() % on_their_way.size();
        deliver(which);
        if (random() % 50 != 0) on_their_way.erase(on_their_way.begin() + static_cast<std::ptrdiff_t>(which));
      }
    }
    link.ReportSpan();
    const LatestCounts counts = link.receiver.Counts();
    EXPECT_EQ(link.sender.sent.load(), kMessages);
    EXPECT_EQ(counts.received + counts.restored + counts.dropped, kMessages);
    // A duplicate is caught by the seal before the reader's tracker sees it; what was restored first repeats.
    EXPECT_EQ(counts.received + counts.repeated, delivered);
    EXPECT_GT(duplicates, 0u);
    EXPECT_GT(counts.reordered, 0u);
    EXPECT_GT(counts.dropped, 0u);
    if (history == 0) {
      EXPECT_EQ(counts.restored, 0u);
    } else {
      EXPECT_LT(counts.dropped, kMessages / 500);
    }
  }
}

TEST(Latest, TheWritersReportRevealsLossesBeforeTheFirstAndAfterTheLastArrival) {
  Link link(true, 0);
  for (std::uint64_t sequence = 1; sequence <= 10; ++sequence) {
    const Bytes bytes = link.Send();
    if (sequence >= 4 && sequence <= 7 && sequence != 5) {
      EXPECT_EQ(link.Deliver(bytes), Refusal::kNone);
    }
  }
  EXPECT_EQ(link.receiver.Counts().dropped, 1u);
  // Messages in the newest report may still be under way.
  link.receiver.TakeReport(9, 1, 8);
  EXPECT_EQ(link.receiver.Counts().dropped, 4u - 3u);
  link.ReportSpan();
  EXPECT_EQ(link.receiver.Counts().dropped, 1u + 3u + 3u);
  EXPECT_EQ(link.receiver.Counts().received, 3u);
  // The writer starts again: its earlier life stays as it was.
  link.sender.envelope.boot = 10;
  link.sender.sequence = 0;
  EXPECT_EQ(link.Deliver(link.Send()), Refusal::kNone);
  EXPECT_EQ(link.receiver.Counts().dropped, 7u);
  EXPECT_EQ(link.receiver.Counts().received, 4u);
  EXPECT_EQ(link.receiver.reader.restarts(), 1u);
}

TEST(Latest, ReportedMessagesOfAGoneWriterCountAsLost) {
  Link link(true, 0);
  EXPECT_EQ(link.Deliver(link.Send()), Refusal::kNone);
  Bytes bytes;
  for (int i = 0; i < 4; ++i) bytes = link.Send();
  link.receiver.TakeReport(9, 1, 5);
  EXPECT_EQ(link.OnTheWay(), 4u);
  EXPECT_EQ(link.receiver.Counts().dropped, 0u);
  link.receiver.Settle();
  EXPECT_EQ(link.OnTheWay(), 0u);
  EXPECT_EQ(link.receiver.Counts().dropped, 4u);
  EXPECT_EQ(link.Deliver(bytes), Refusal::kNone);  // it was in the reader's socket
  EXPECT_EQ(link.receiver.Counts().received, 2u);
  EXPECT_EQ(link.receiver.Counts().dropped, 3u);
}

TEST(Latest, TheLostTailOfALifeIsCountedWhenTheNextReportsFirst) {
  Link link(true, 0);
  EXPECT_EQ(link.Deliver(link.Send()), Refusal::kNone);
  link.receiver.TakeReport(9, 1, 5);
  // The next life is reported before any of its messages arrives.
  link.receiver.TakeReport(10, 1, 2);
  EXPECT_EQ(link.receiver.Counts().dropped, 4u);
  EXPECT_EQ(link.OnTheWay(), 2u);
  link.receiver.TakeReport(9, 1, 6);  // overtaken on the way
  link.sender.envelope.boot = 10;
  link.sender.sequence = 1;
  EXPECT_EQ(link.Deliver(link.Send()), Refusal::kNone);
  link.receiver.Settle();
  EXPECT_EQ(link.OnTheWay(), 0u);
  EXPECT_EQ(link.receiver.Counts().received, 2u);
  EXPECT_EQ(link.receiver.Counts().dropped, 4u + 1u);
}

// The reader's count of the present life must equal what the writer sent in it.
TEST(Latest, AReaderCountsEachLifeOfTheWriterForItself) {
  std::mt19937_64 random(3);
  Link link;
  for (std::uint64_t life = 0; life < 5; ++life) {
    link.sender.envelope.boot = 9 + life;
    link.sender.sequence = 100 * life;
    link.sender.spans[0].instance = 0;  // as a new process has it
    std::vector<Bytes> late;
    for (std::uint64_t i = 0; i < 300; ++i) {
      const Bytes bytes = link.Send();
      if (random() % 4 == 0) continue;
      if (random() % 8 == 0) {
        late.push_back(bytes);
      } else {
        EXPECT_EQ(link.Deliver(bytes), Refusal::kNone);
      }
    }
    link.ReportSpan();
    for (const Bytes& bytes : late) link.Deliver(bytes);
    const LatestLife read = link.receiver.Life();
    EXPECT_EQ(read.boot, 9 + life);
    EXPECT_EQ(read.first, 100 * life + 1);
    EXPECT_EQ(read.reported(), 300u);
    EXPECT_EQ(read.on_the_way, 0u);
    EXPECT_EQ(read.received + read.restored + read.lost, 300u);
    EXPECT_GT(read.lost, 0u);
    const LatestCounts counts = link.receiver.Counts();
    EXPECT_EQ(counts.meant, 300 * (life + 1));
    EXPECT_EQ(counts.received + counts.restored + counts.dropped, 300 * (life + 1));
  }
}

// All members of a group receive its datagrams, even before the writer counts them as readers.
TEST(Latest, DatagramsForOtherReadersOfTheGroupAreCountedApart) {
  Link link(true, 0);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(link.Deliver(link.Send()), Refusal::kNone);
  link.sender.spans[0].first = 3;
  link.ReportSpan();
  const LatestLife read = link.receiver.Life();
  EXPECT_EQ(read.early, 2u);
  EXPECT_EQ(read.counted(), read.reported());
}

TEST(Latest, LateAndRestoredSamplesHaveTimesOfThisMachinesClock) {
  constexpr std::int64_t kOffset_ns = 5 * core::kMillisecond_ns;
  Link link;
  link.receiver.clock_offset_ns = kOffset_ns;
  link.trace.id = core::MakeTraceId(0, 1);
  link.trace.origin_ns = 7 * core::kMillisecond_ns;
  std::map<std::uint64_t, std::int64_t> published_ns;
  const auto send = [&] {
    const Bytes bytes = link.Send();
    published_ns[link.sender.sequence] = link.sender.envelope.header.publish_ns;
    return bytes;
  };
  EXPECT_EQ(link.Deliver(send()), Refusal::kNone);
  send();  // lost: 2 comes with 4, and 3 is late
  const Bytes third = send();
  const std::vector<Bytes> rest = {send(), send(), send(), send(), send()};
  EXPECT_EQ(link.Deliver(rest[0]), Refusal::kNone);
  EXPECT_EQ(link.Deliver(rest[4]), Refusal::kNone);
  EXPECT_EQ(link.Deliver(rest[1]), Refusal::kNone);  // late, and no copy of it has come
  EXPECT_EQ(link.Deliver(third), Refusal::kNone);    // its copy was first
  EXPECT_EQ(link.receiver.Counts().restored, 4u);
  for (const std::uint64_t sequence : {1, 2, 3, 4, 5, 6, 7, 8}) {
    const core::HapticProxy* sample = link.receiver.reader.Sample(sequence);
    ASSERT_NE(sample, nullptr) << sequence;
    EXPECT_EQ(sample->header.publish_ns, published_ns[sequence] - kOffset_ns) << sequence;
    EXPECT_EQ(sample->header.direct.origin_ns, link.trace.origin_ns - kOffset_ns) << sequence;
  }
}

TEST(Latest, ALaterReaderInTheSameSlotHasAnAccountOfItsOwn) {
  Link link(true, 0);
  link.Send();
  link.Send();
  const Subscriber before = link.sender.subscribers.value()[0];
  Subscribers readers;
  for (std::uint64_t i = 0; i < kMaxSubscribers; ++i) readers.push_back({before.address, 100 + i, 0, false});
  link.sender.SetReaders(readers);  // all slots are needed, so the first reader's goes
  core::HapticProxy proxy;
  EXPECT_EQ(link.sender.Send(&proxy), static_cast<int>(kMaxSubscribers));
  std::set<std::uint64_t> reported;
  for (const SpanAccount& span : link.sender.spans) {
    reported.insert(span.instance);
    EXPECT_EQ(span.first, 3u);
    EXPECT_EQ(span.last, 3u);
  }
  EXPECT_EQ(reported.size(), kMaxSubscribers);
  EXPECT_EQ(reported.count(kReader), 0u);
}

// Period T, hops of at most h, random losses, reads at any time: when the k newest messages that are due were lost, the
// value read was published at most (k + 1) T + h ago.
TEST(Latest, AgeIsAtMostConsecutiveLossesPlusOnePeriodsPlusHop) {
  constexpr std::int64_t kPeriod_ns = core::kMillisecond_ns;
  constexpr std::int64_t kMaxHop_ns = 300'000;
  for (const unsigned loss_per_mille : {0u, 1u, 10u, 50u, 500u}) {
    std::mt19937_64 random(loss_per_mille + 1);
    Link link(true, 0);
    std::multimap<std::int64_t, Bytes> on_their_way;  // by arrival
    std::uint64_t sent = 0, in_a_row = 0;
    std::int64_t worst_ns = 0;
    std::map<std::uint64_t, bool> is_lost;
    for (std::int64_t now_ns = kPeriod_ns; now_ns < 5'000 * kPeriod_ns;
         now_ns += 1 + static_cast<std::int64_t>(random() % 250'000)) {
      while (static_cast<std::int64_t>(sent + 1) * kPeriod_ns <= now_ns) {
        ++sent;
        const Bytes bytes = link.Send();
        is_lost[sent] = sent > 1 && random() % 1000 < loss_per_mille;
        const std::int64_t hop_ns = static_cast<std::int64_t>(random() % kMaxHop_ns);
        if (!is_lost[sent]) on_their_way.emplace(static_cast<std::int64_t>(sent) * kPeriod_ns + hop_ns, bytes);
      }
      while (!on_their_way.empty() && on_their_way.begin()->first <= now_ns) {
        EXPECT_EQ(link.Deliver(on_their_way.begin()->second, on_their_way.begin()->first), Refusal::kNone);
        on_their_way.erase(on_their_way.begin());
      }
      const auto& reader = link.receiver.reader;
      if (!reader.has_value()) continue;
      const std::int64_t age_ns = now_ns - static_cast<std::int64_t>(reader.value().cycle) * kPeriod_ns;
      // Due: published at least one hop ago.
      std::uint64_t due = static_cast<std::uint64_t>((now_ns - kMaxHop_ns) / kPeriod_ns);
      in_a_row = 0;
      while (due > 1 && is_lost[due]) {
        --due;
        ++in_a_row;
      }
      ASSERT_LE(age_ns, static_cast<std::int64_t>(in_a_row + 1) * kPeriod_ns + kMaxHop_ns);
      ASSERT_LE(reader.age_ns(now_ns), age_ns);
      worst_ns = std::max(worst_ns, age_ns);
    }
    EXPECT_GT(worst_ns, kPeriod_ns);  // the bound is tight enough to matter
    if (loss_per_mille == 0) {
      EXPECT_LE(worst_ns, kPeriod_ns + kMaxHop_ns);
    }
  }
}

TEST(Latest, PublishAgeIncludesTheClockOffset) {
  Link link;
  ASSERT_EQ(link.Deliver(link.Send(), 1'000), Refusal::kNone);
  const auto& reader = link.receiver.reader;
  const std::int64_t published_ns = reader.value().header.publish_ns;
  EXPECT_EQ(reader.publish_age_ns(published_ns + 70), 70);
  EXPECT_EQ(reader.publish_age_ns(published_ns + 70, 50), 20);  // this host's clock is 50 ns ahead
  EXPECT_EQ(reader.age_ns(1'600), 600);
  EXPECT_FALSE(reader.is_stale(1'000 + 10 * core::kMillisecond_ns));
  EXPECT_TRUE(reader.is_stale(1'001 + 10 * core::kMillisecond_ns));
}

TEST(EarlierSamples, ParsingStaysWithinTheBytes) {
  std::mt19937_64 random(9);
  for (int round = 0; round < 100'000; ++round) {
    Bytes bytes(random() % 300);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random() % 4 == 0 ? random() : random() % 3);
    std::span<const std::uint8_t> blocks(bytes);
    EarlierSample sample;
    while (NextEarlierSample(1000, &blocks, &sample)) {
      ASSERT_GE(sample.payload.data(), bytes.data());
      ASSERT_LE(sample.payload.data() + sample.payload.size(), bytes.data() + bytes.size());
      ASSERT_LT(sample.header.sequence, 1000u);
    }
  }
}

}  // namespace
}  // namespace bus::detail
