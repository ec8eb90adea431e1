#include "nodes/visual_node/walls/kept_ticks.hpp"

#include <gtest/gtest.h>

#include <initializer_list>

namespace visual_node {
namespace {

KeptTicks Kept(std::initializer_list<std::uint64_t> ticks) {
  KeptTicks kept;
  for (const std::uint64_t tick : ticks) kept.Add(tick);
  return kept;
}

TEST(KeptTicks, HasWhatWasAddedAndNothingElse) {
  const KeptTicks kept = Kept({8, 12, 20, 24});
  for (const std::uint64_t tick : {8, 12, 20, 24}) EXPECT_TRUE(kept.Has(tick)) << tick;
  for (const std::uint64_t tick : {0, 4, 16, 22, 28}) EXPECT_FALSE(kept.Has(tick)) << tick;
  EXPECT_FALSE(KeptTicks().Has(0));
}

TEST(KeptTicks, ForgetsAllButTheNewestSixtyFourPeriods) {
  KeptTicks kept = Kept({4, 8, 12});
  kept.Add(8 + 64 * 4);
  EXPECT_FALSE(kept.Has(4));
  EXPECT_FALSE(kept.Has(8));
  EXPECT_TRUE(kept.Has(12));
  kept.Add(4000);
  EXPECT_FALSE(kept.Has(12));
  EXPECT_TRUE(kept.Has(4000));
}

// Walls that each lack other states, as on a busy machine, still have one in common.
TEST(NewestCommonTick, IsOneThatAllWallsHave) {
  const KeptTicks own = Kept({100, 104, 108, 116, 120});
  EXPECT_EQ(NewestCommonTick(own, {}, 0), 120u);
  EXPECT_EQ(NewestCommonTick(own, {Kept({100, 108, 116}), Kept({100, 104, 108, 112, 120, 124})}, 0), 108u);
}

TEST(NewestCommonTick, IsTheLastNamedOneWhenThereIsNoOther) {
  const KeptTicks own = Kept({700, 704});
  EXPECT_EQ(NewestCommonTick(own, {Kept({696})}, 300), 300u) << "all walls still have it";
  EXPECT_EQ(NewestCommonTick(own, {Kept({696})}, 0), 704u) << "nothing was named before";
  EXPECT_EQ(NewestCommonTick(own, {Kept({696})}, 9000), 704u) << "named before physics began anew";
  EXPECT_EQ(NewestCommonTick(own, {Kept({696})}, 200), 704u) << "a picture does not stand still for longer";
}

TEST(NewestCommonTick, DoesNotWaitForAWallWithoutStates) {
  const KeptTicks own = Kept({900, 904});
  EXPECT_EQ(NewestCommonTick(own, {KeptTicks(), Kept({900, 908})}, 896), 900u) << "none have arrived there";
  EXPECT_EQ(NewestCommonTick(own, {Kept({400})}, 896), 904u) << "they have stopped there";
  EXPECT_EQ(NewestCommonTick({}, {Kept({96})}, 0), 0u);
}

}  // namespace
}  // namespace visual_node
