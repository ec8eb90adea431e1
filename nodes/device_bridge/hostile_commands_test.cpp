#include "nodes/device_bridge/testing/hostile_commands.hpp"

#include <gtest/gtest.h>

namespace device_bridge {
namespace {

TEST(HostileCommands, NoneOfAHundredThousandGivesADeviceAForceAboveItsLimits) {
  std::uint64_t num_acting = 0;
  EXPECT_EQ(CountViolations(100'000, 1, &num_acting), 0U);
  EXPECT_GT(num_acting, 5'000U) << "otherwise a filter that blocks everything would pass";
}

}  // namespace
}  // namespace device_bridge
