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
  EXPECT_EQ(NewestCommonTick(own, {}), 120u);
  EXPECT_EQ(NewestCommonTick(own, {Kept({100, 108, 116}), Kept({100, 104, 108, 112, 120, 124})}), 108u);
  EXPECT_EQ(NewestCommonTick(own, {Kept({96})}), 0u);
  EXPECT_EQ(NewestCommonTick({}, {Kept({96})}), 0u);
}

}  // namespace
}  // namespace visual_node
