#include "physics/press_support.hpp"

namespace physics {
namespace {

TEST(SlowContactPoints, FlatPressOfTenThousandPointsNeverRocksInTenSeconds) {
  EXPECT_LT(test::RockingOfAPress_m(10.0), 5e-6);
}

}  // namespace
}  // namespace physics
