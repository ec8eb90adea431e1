#include "nodes/visual_node/walls/named_tick.hpp"

#include <gtest/gtest.h>

#include "core/clock.hpp"
#include "nodes/visual_node/testing/kept_of.hpp"

namespace visual_node {
namespace {

TEST(NamedTick, IsTheNewestThatAllWallsHave) {
  NamedTick named;
  EXPECT_EQ(named.Next(KeptOf({96, 100, 104}),
                       {{KeptOf({96, 104}), 5 * core::kMillisecond_ns},
                        {KeptOf({96, 100, 104, 108}), 6 * core::kMillisecond_ns}},
                       7 * core::kMillisecond_ns),
            104u);
  EXPECT_EQ(
      named.Next(KeptOf({100, 104, 108}), {{KeptOf({100}), 5 * core::kMillisecond_ns}}, 9 * core::kMillisecond_ns),
      100u);
}

TEST(NamedTick, IsTheLastOneAgainWhileWallsHaveNoneInCommon) {
  NamedTick named;
  const NamedTick::Claim other{KeptOf({100}), 10 * core::kMillisecond_ns};
  EXPECT_EQ(named.Next(KeptOf({100}), {other}, 10 * core::kMillisecond_ns), 100u);
  EXPECT_EQ(named.Next(KeptOf({400, 404}), {other}, 400 * core::kMillisecond_ns), 100u)
      << "it was not heard for long, and may be there";
  EXPECT_EQ(named.Next(KeptOf({404, 900}), {{KeptOf({896}), 890 * core::kMillisecond_ns}}, 900 * core::kMillisecond_ns),
            100u);
  EXPECT_EQ(named.Next(KeptOf({900, 904}), {{KeptOf({900}), 905 * core::kMillisecond_ns}}, 910 * core::kMillisecond_ns),
            900u);
}

TEST(NamedTick, StandsStillForADeadWallOnceForASecond) {
  NamedTick named;
  const NamedTick::Claim dead{KeptOf({1000}), 1000 * core::kMillisecond_ns};
  const auto lives_on = [](std::uint64_t ms) {
    return NamedTick::Claim{KeptOf({ms - ms % 4}), static_cast<std::int64_t>(ms) * core::kMillisecond_ns};
  };
  std::uint64_t stood_still_ms = 0;
  for (std::uint64_t ms = 1000; ms < 5000; ms += 20) {
    const std::uint64_t tick =
        named.Next(KeptOf({ms}), {dead, lives_on(ms)}, static_cast<std::int64_t>(ms) * core::kMillisecond_ns);
    if (tick == 1000 && ms > 1000) stood_still_ms = ms - 1000;
    EXPECT_TRUE(tick == 1000 || tick == ms) << "one of those that are there, then";
  }
  EXPECT_NEAR(static_cast<double>(stood_still_ms), 1000.0, 20.0);
}

TEST(NamedTick, IsTheFirstWallsNewestWithoutOthersAndAfterPhysicsBeganAnew) {
  NamedTick named;
  EXPECT_EQ(named.Next(KeptOf({5000}), {}, 10 * core::kMillisecond_ns), 5000u);
  EXPECT_EQ(named.Next(KeptOf({5004}), {{KeptTicks(), 15 * core::kMillisecond_ns}}, 16 * core::kMillisecond_ns), 5004u)
      << "it has no states yet";
  EXPECT_EQ(named.Next(KeptOf({8}), {{KeptOf({5004}), 20 * core::kMillisecond_ns}}, 20 * core::kMillisecond_ns), 8u);
  EXPECT_EQ(NamedTick().Next({}, {{KeptOf({96}), core::kMillisecond_ns}}, core::kMillisecond_ns), 0u)
      << "nothing has arrived here";
}

}  // namespace
}  // namespace visual_node
