#include "bus/testing/joins.hpp"

#include <gtest/gtest.h>

#include <random>

namespace bus {
namespace {

TEST(Joins, EveryJoinerGetsTheCompleteStateOnce) {
  const std::uint64_t seed = std::random_device()();
  SCOPED_TRACE("seed " + std::to_string(seed));
  testing::Joins joins(seed);
  joins.Run(24);
}

}  // namespace
}  // namespace bus
