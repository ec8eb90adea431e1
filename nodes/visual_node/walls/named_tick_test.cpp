#include "nodes/visual_node/walls/named_tick.hpp"

#include <gtest/gtest.h>

#include <initializer_list>

namespace visual_node {
namespace {

constexpr std::int64_t kMs = 1'000'000;

KeptTicks Kept(std::initializer_list<std::uint64_t> ticks) {
  KeptTicks kept;
  for (const std::uint64_t tick : ticks) kept.Add(tick);
  return kept;
}

TEST(NamedTick, IsTheNewestThatAllWallsHave) {
  NamedTick named;
  EXPECT_EQ(
      named.Next(Kept({96, 100, 104}), {{Kept({96, 104}), 5 * kMs}, {Kept({96, 100, 104, 108}), 6 * kMs}}, 7 * kMs),
      104u);
  EXPECT_EQ(named.Next(Kept({100, 104, 108}), {{Kept({100}), 5 * kMs}}, 9 * kMs), 100u);
}

TEST(NamedTick, IsTheLastOneAgainWhileWallsHaveNoneInCommon) {
  NamedTick named;
  const NamedTick::Claim other{Kept({100}), 10 * kMs};
  EXPECT_EQ(named.Next(Kept({100}), {other}, 10 * kMs), 100u);
  EXPECT_EQ(named.Next(Kept({400, 404}), {other}, 400 * kMs), 100u) << "it was not heard for long, and may be there";
  EXPECT_EQ(named.Next(Kept({404, 900}), {{Kept({896}), 890 * kMs}}, 900 * kMs), 100u);
  EXPECT_EQ(named.Next(Kept({900, 904}), {{Kept({900}), 905 * kMs}}, 910 * kMs), 900u);
}

TEST(NamedTick, StandsStillForADeadWallOnceForASecond) {
  NamedTick named;
  const NamedTick::Claim dead{Kept({1000}), 1000 * kMs};
  const auto lives_on = [](std::uint64_t ms) {
    return NamedTick::Claim{Kept({ms - ms % 4}), static_cast<std::int64_t>(ms) * kMs};
  };
  std::uint64_t stood_still_ms = 0;
  for (std::uint64_t ms = 1000; ms < 5000; ms += 20) {
    const std::uint64_t tick = named.Next(Kept({ms}), {dead, lives_on(ms)}, static_cast<std::int64_t>(ms) * kMs);
    if (tick == 1000 && ms > 1000) stood_still_ms = ms - 1000;
    EXPECT_TRUE(tick == 1000 || tick == ms) << "one of those that are there, then";
  }
  EXPECT_NEAR(static_cast<double>(stood_still_ms), 1000.0, 20.0);
}

TEST(NamedTick, IsTheFirstWallsNewestWithoutOthersAndAfterPhysicsBeganAnew) {
  NamedTick named;
  EXPECT_EQ(named.Next(Kept({5000}), {}, 10 * kMs), 5000u);
  EXPECT_EQ(named.Next(Kept({5004}), {{KeptTicks(), 15 * kMs}}, 16 * kMs), 5004u) << "it has no states yet";
  EXPECT_EQ(named.Next(Kept({8}), {{Kept({5004}), 20 * kMs}}, 20 * kMs), 8u);
  EXPECT_EQ(NamedTick().Next({}, {{Kept({96}), kMs}}, kMs), 0u) << "nothing has arrived here";
}

}  // namespace
}  // namespace visual_node
