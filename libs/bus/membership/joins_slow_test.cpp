#include <gtest/gtest.h>

#include <cstdio>
#include <random>

#include "bus/testing/joins.hpp"

namespace bus {
namespace {

// "Late joiner": complete, correct state within 200 ms; nothing lost or doubled in 1,000 random joins and leaves.
TEST(Joins, AThousandAreCompleteWithin200ms) {
  const std::uint64_t seed = std::random_device()();
  SCOPED_TRACE("seed " + std::to_string(seed));
  testing::Joins joins(seed);
  const auto result = joins.Run(1'000);
  const std::vector<double>& ms = result.complete_ms;
  ASSERT_GT(ms.size(), 800u);  // some leave before they have it
  const auto at = [&ms](double part) {
    return ms[static_cast<std::size_t>(part * static_cast<double>(ms.size() - 1))];
  };
  std::printf("complete after p50 %.1f p90 %.1f p99 %.1f max %.1f ms, n %zu, seed %llu\n", at(0.5), at(0.9), at(0.99),
              ms.back(), ms.size(), static_cast<unsigned long long>(seed));
  EXPECT_LE(at(0.99), 200.0);
}

}  // namespace
}  // namespace bus
