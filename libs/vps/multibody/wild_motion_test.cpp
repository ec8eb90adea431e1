#include "vps/testing/wild_motion.hpp"

#include <gtest/gtest.h>

// A short run of wild_motion_slow_test.cpp.
namespace vps {
namespace {

class WildMotion : public testing::TestWithParam<Method> {};

TEST_P(WildMotion, NoContactIsFoundLate) {
  const test::WildCounts counts = test::RunWildly(GetParam(), 1, 15000);
  EXPECT_EQ(counts.late, 0U);
  EXPECT_EQ(counts.missed, 0U);
  EXPECT_EQ(counts.too_far, 0U);
  EXPECT_GT(counts.begins, 100U);
  EXPECT_GT(counts.skipped, 100000U);
}

INSTANTIATE_TEST_SUITE_P(Methods, WildMotion, testing::Values(Method::kPaper, Method::kFast),
                         [](const auto& run) { return std::string(run.param == Method::kFast ? "fast" : "paper"); });

}  // namespace
}  // namespace vps
