#include <gtest/gtest.h>

#include "nodes/device_bridge/testing/hostile_commands.hpp"

namespace device_bridge {
namespace {

TEST(HostileCommands, NoneOfTenMillionGivesADeviceAForceAboveItsLimits) {
  std::uint64_t num_acting = 0;
  EXPECT_EQ(CountViolations(10'000'000, 2, &num_acting), 0U);
  EXPECT_GT(num_acting, 500'000U) << "otherwise a filter that blocks everything would pass";
}

}  // namespace
}  // namespace device_bridge
