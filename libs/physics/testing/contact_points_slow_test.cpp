#include <gtest/gtest.h>

#include "physics/testing/trials/reference.hpp"

namespace physics {
namespace {

TEST(SlowContactPoints, FlatPressOfTenThousandPointsNeverRocksInTenSeconds) {
  EXPECT_LT(trials::RockingOfAPress_m(10.0), 5e-6);
}

}  // namespace
}  // namespace physics
