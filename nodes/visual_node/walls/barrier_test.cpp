#include "nodes/visual_node/walls/barrier.hpp"

#include <gtest/gtest.h>

#include "core/clock.hpp"

namespace visual_node {
namespace {

TEST(Barrier, OpensWhenTheLastWallHasDrawn) {
  Barrier barrier(2);
  barrier.Take(0, 6, 0);
  barrier.Take(1, 6, 0);
  barrier.Begin(7, 0);
  EXPECT_FALSE(barrier.IsOpen(1 * core::kMillisecond_ns));
  barrier.Take(0, 7, 5 * core::kMillisecond_ns);
  EXPECT_FALSE(barrier.IsOpen(6 * core::kMillisecond_ns));
  barrier.Take(1, 7, 9 * core::kMillisecond_ns);
  EXPECT_TRUE(barrier.IsOpen(10 * core::kMillisecond_ns));
  barrier.Begin(8, 11 * core::kMillisecond_ns);
  EXPECT_FALSE(barrier.IsOpen(12 * core::kMillisecond_ns));
  EXPECT_EQ(barrier.NumInStep(12 * core::kMillisecond_ns), 2u);
}

TEST(Barrier, DoesNotWaitForAWallThatIsNotThereYetOrAnyMore) {
  Barrier barrier(2);
  barrier.Begin(1, 0);
  EXPECT_TRUE(barrier.IsOpen(0)) << "none has said anything yet";
  barrier.Take(0, 1, 0);
  barrier.Begin(2, 10 * core::kMillisecond_ns);
  EXPECT_FALSE(barrier.IsOpen(299 * core::kMillisecond_ns));
  EXPECT_TRUE(barrier.IsOpen(300 * core::kMillisecond_ns)) << "it is silent, perhaps dead";
  EXPECT_EQ(barrier.NumInStep(300 * core::kMillisecond_ns), 0u);
}

// Its other thread still talks, but it draws no more.
TEST(Barrier, WaitsForAWallThatHangsOnlyOnceUntilItHasCaughtUp) {
  Barrier barrier(1);
  std::int64_t now_ns = 0;
  const auto opens_after_ms = [&](std::uint64_t frame, std::uint64_t drawn) {
    barrier.Begin(frame, now_ns);
    for (int ms = 0;; ++ms, now_ns += core::kMillisecond_ns) {
      barrier.Take(0, drawn, now_ns);
      if (barrier.IsOpen(now_ns)) return ms;
    }
  };
  EXPECT_EQ(opens_after_ms(2, 1), 1000);
  EXPECT_EQ(opens_after_ms(3, 1), 0);
  EXPECT_EQ(opens_after_ms(4, 1), 0);
  EXPECT_EQ(barrier.NumInStep(now_ns), 0u);
  EXPECT_EQ(opens_after_ms(5, 5), 0) << "it draws again";
  EXPECT_EQ(opens_after_ms(6, 5), 1000);
}

}  // namespace
}  // namespace visual_node
