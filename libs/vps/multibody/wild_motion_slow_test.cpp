#include <gtest/gtest.h>

#include "vps/testing/wild_motion.hpp"

namespace vps {
namespace {

// A million steps: 2 m/s closing, a tool of 1 m at 2 rad/s, flung, tumbling, resting and jumping parts, 21 pairs.
TEST(WildMotionSlow, NoContactIsFoundLateInAMillionSteps) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const test::WildCounts counts = test::RunWildly(Method::kFast, seed, 100000);
    ASSERT_EQ(counts.late, 0U) << "seed " << seed;
    ASSERT_EQ(counts.missed, 0U) << "seed " << seed;
    ASSERT_EQ(counts.too_far, 0U) << "seed " << seed;
    ASSERT_GT(counts.begins, 1000U) << "seed " << seed;
    ASSERT_GT(counts.skipped, 1000000U) << "seed " << seed;
  }
}

}  // namespace
}  // namespace vps
