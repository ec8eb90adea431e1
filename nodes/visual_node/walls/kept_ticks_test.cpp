#include "nodes/visual_node/walls/kept_ticks.hpp"

#include <gtest/gtest.h>

#include "nodes/visual_node/testing/kept_of.hpp"

namespace visual_node {
namespace {

TEST(KeptTicks, HasWhatWasAddedAndNothingElse) {
  const KeptTicks kept = KeptOf({8, 12, 20, 24});
  for (const std::uint64_t tick : {8, 12, 20, 24}) EXPECT_TRUE(kept.Has(tick)) << tick;
  for (const std::uint64_t tick : {0, 4, 16, 22, 28}) EXPECT_FALSE(kept.Has(tick)) << tick;
  EXPECT_FALSE(KeptTicks().Has(0));
}

TEST(KeptTicks, ForgetsAllButTheNewestSixtyFourPeriods) {
  KeptTicks kept = KeptOf({4, 8, 12});
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
  const KeptTicks own = KeptOf({100, 104, 108, 116, 120});
  EXPECT_EQ(NewestCommonTick(own, {}), 120u);
  EXPECT_EQ(NewestCommonTick(own, {KeptOf({100, 108, 116}), KeptOf({100, 104, 108, 112, 120, 124})}), 108u);
  EXPECT_EQ(NewestCommonTick(own, {KeptOf({96})}), 0u);
  EXPECT_EQ(NewestCommonTick({}, {KeptOf({96})}), 0u);
}

}  // namespace
}  // namespace visual_node
