#include <gtest/gtest.h>

#include <random>

#include "bus/joins_testing.hpp"

namespace bus {
namespace {

TEST(Joins, WhoeverComesAndGoesHasTheWholeStateOnce) {
  const std::uint64_t seed = std::random_device()();
  SCOPED_TRACE("seed " + std::to_string(seed));
  testing::Joins joins(seed);
  joins.Run(24);
}

}  // namespace
}  // namespace bus
