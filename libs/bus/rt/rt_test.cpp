#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <thread>
#include <vector>

#include "bus/rt/latency_stats.hpp"
#include "bus/rt/latest_value.hpp"
#include "bus/rt/periodic_loop.hpp"
#include "bus/rt/spsc_ring.hpp"
#include "bus/rt/thread_setup.hpp"
#include "bus/rt/worker_pool.hpp"

namespace bus {
namespace {

constexpr int kValues = 200'000;

TEST(LatestValue, ReaderSeesWholeValuesInOrderAndTheLastOne) {
  using Value = std::array<std::uint64_t, 16>;
  LatestValue<Value> shared;
  std::thread writer([&shared] {
    for (std::uint64_t i = 1; i <= kValues; ++i) {
      Value value;
      value.fill(i);
      shared.Write(value);
    }
  });
  std::uint64_t last = 0;
  while (last < kValues) {
    if (!shared.Update()) continue;
    const Value& value = shared.value();
    ASSERT_GT(value[0], last);
    ASSERT_EQ(shared.sequence(), value[0]);
    ASSERT_TRUE(std::all_of(value.begin(), value.end(), [&](std::uint64_t v) { return v == value[0]; }));
    last = value[0];
  }
  writer.join();
  EXPECT_FALSE(shared.Update());
}

TEST(SpscRing, DeliversEverythingOnceAndInOrder) {
  SpscRing<std::uint64_t> ring(64);
  std::thread producer([&ring] {
    for (std::uint64_t i = 0; i < kValues;) {
      if (ring.Push(i)) ++i;
    }
  });
  for (std::uint64_t expected = 0; expected < kValues;) {
    std::uint64_t value = 0;
    if (!ring.Pop(&value)) continue;
    ASSERT_EQ(value, expected);
    ++expected;
  }
  producer.join();
}

TEST(SpscRing, RefusesAndCountsOverflow) {
  SpscRing<int> ring(3);
  EXPECT_TRUE(ring.Push(1));
  EXPECT_TRUE(ring.Push(2));
  EXPECT_TRUE(ring.Push(3));
  EXPECT_FALSE(ring.Push(4));
  EXPECT_EQ(ring.overflows(), 1u);
  int value = 0;
  ASSERT_TRUE(ring.Pop(&value));
  EXPECT_EQ(value, 1);
  EXPECT_TRUE(ring.Push(5));
}

TEST(PeriodicLoop, TicksAtAbsoluteTimesAndCountsWhatItMissed) {
  PeriodicLoop loop(1'000, 10'000);
  EXPECT_EQ(loop.next_due_ns(), 10'000);
  TickInfo tick = loop.Advance(10'100);
  EXPECT_EQ(tick.index, 0u);
  EXPECT_EQ(tick.scheduled_ns, 10'000);
  EXPECT_EQ(tick.skipped, 0u);
  tick = loop.Advance(11'999);  // late, but within its period
  EXPECT_EQ(tick.index, 1u);
  EXPECT_EQ(tick.skipped, 0u);
  tick = loop.Advance(15'500);  // due at 12'000: three ticks are gone
  EXPECT_EQ(tick.index, 5u);
  EXPECT_EQ(tick.scheduled_ns, 15'000);
  EXPECT_EQ(tick.skipped, 3u);
  EXPECT_EQ(loop.skipped(), 3u);
  EXPECT_EQ(loop.ticks(), 3u);
  EXPECT_EQ(loop.next_due_ns(), 16'000);
  EXPECT_EQ(loop.max_wake_delay_ns(), 999);
}

TEST(PeriodicLoop, DoesNotWakeEarlyOrDrift) {
  const std::int64_t start = core::MonotonicNow_ns() + core::kTick_ns;
  PeriodicLoop loop(core::kTick_ns, start);
  TickInfo tick;
  while (tick.index < 20) {
    tick = loop.WaitNext();
    EXPECT_EQ(tick.scheduled_ns, start + static_cast<std::int64_t>(tick.index) * core::kTick_ns);
    EXPECT_GE(tick.woke_ns, tick.scheduled_ns);
  }
}

TEST(LatencyStats, PercentilesAgreeWithTheSortedSamples) {
  std::mt19937_64 random(11);
  LatencyStats stats;
  std::vector<std::int64_t> samples;
  double sum = 0;
  for (int i = 0; i < 50'000; ++i) {
    const auto sample = static_cast<std::int64_t>(random() >> (34 + random() % 20));  // over six decades
    samples.push_back(sample);
    stats.Add(sample);
    sum += static_cast<double>(sample);
  }
  std::sort(samples.begin(), samples.end());
  EXPECT_EQ(stats.count(), samples.size());
  EXPECT_EQ(stats.min_ns(), samples.front());
  EXPECT_EQ(stats.max_ns(), samples.back());
  EXPECT_NEAR(stats.mean_ns(), sum / static_cast<double>(samples.size()), 1e-6 * stats.mean_ns());
  for (const double fraction : {0.5, 0.9, 0.99, 0.999, 1.0}) {
    const auto rank = static_cast<std::size_t>(std::ceil(fraction * static_cast<double>(samples.size()))) - 1;
    const auto exact = static_cast<double>(samples[rank]);
    EXPECT_GE(stats.Percentile_ns(fraction), exact);
    EXPECT_LE(stats.Percentile_ns(fraction), exact * (1.0 + 1.0 / 31) + 1);
  }
}

TEST(LatencyStats, MergeEqualsAddingToOne) {
  LatencyStats a, b, both;
  for (std::int64_t i = 0; i < 1000; ++i) {
    (i % 3 == 0 ? a : b).Add(i * i);
    both.Add(i * i);
  }
  a.Merge(b);
  EXPECT_EQ(a.count(), both.count());
  EXPECT_EQ(a.max_ns(), both.max_ns());
  EXPECT_EQ(a.p99_ns(), both.p99_ns());
  EXPECT_DOUBLE_EQ(a.mean_ns(), both.mean_ns());
  EXPECT_EQ(LatencyStats{}.p50_ns(), 0.0);
}

TEST(ThreadSetup, ReportsWhatWasGranted) {
  std::thread thread([] {
    const ThreadReport off = SetUpThread({"rt-test", RealTimeMode::kOff, 10, false, 0});
    EXPECT_TRUE(off.is_ok);
    EXPECT_FALSE(off.is_fifo);
    // Product of the smallest normal number and 0.5 is denormal: flushed to zero.
    volatile double tiny = 2.2250738585072014e-308;
    EXPECT_EQ(tiny * 0.5, 0.0);
    const ThreadReport tried = SetUpThread({"rt-test", RealTimeMode::kTry, 10, false, 0});
    EXPECT_TRUE(tried.is_ok);
    EXPECT_NE(tried.text.find(tried.is_fifo ? "FIFO 10" : "no FIFO"), std::string::npos) << tried.text;
    const ThreadReport enforced = SetUpThread({"rt-test", RealTimeMode::kEnforce, 10, false, 0});
    EXPECT_EQ(enforced.is_ok, enforced.is_fifo);
  });
  thread.join();
  RealTimeMode mode{};
  EXPECT_TRUE(ParseRealTimeMode("enforce", &mode));
  EXPECT_EQ(mode, RealTimeMode::kEnforce);
  EXPECT_FALSE(ParseRealTimeMode("maybe", &mode));
}

struct Work {
  std::vector<double> slots;
  std::vector<std::uint32_t> visits;
  int round = 0;
};

void Compute(void* context, std::size_t i) {
  auto& work = *static_cast<Work*>(context);
  double value = static_cast<double>(i) + work.round;
  for (int k = 0; k < 20; ++k) value = value * 1.0000001 + 0.1;
  work.slots[i] = value;
  ++work.visits[i];
}

TEST(WorkerPool, RunsEveryBodyOnceWithTheSameResultForAnyNumberOfWorkers) {
  std::vector<double> reference;
  for (const unsigned workers : {1U, 2U, 4U}) {
    WorkerPool pool(workers);
    EXPECT_EQ(pool.num_workers(), workers);
    Work work;
    for (int round = 0; round < 2'000; ++round) {
      const std::size_t count = static_cast<std::size_t>(round % 50);
      work.slots.assign(count, 0.0);
      work.visits.assign(count, 0);
      work.round = round;
      pool.Run(count, Compute, &work);
      ASSERT_TRUE(std::all_of(work.visits.begin(), work.visits.end(), [](std::uint32_t n) { return n == 1; })) << round;
    }
    if (reference.empty()) reference = work.slots;
    EXPECT_EQ(work.slots, reference);
  }
}

}  // namespace
}  // namespace bus
