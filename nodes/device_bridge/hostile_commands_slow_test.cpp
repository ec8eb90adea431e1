#include <gtest/gtest.h>

#include "nodes/device_bridge/testing/hostile_commands.hpp"

namespace device_bridge {
namespace {

class HostileCommands : public ::testing::TestWithParam<AttackCase> {};

TEST_P(HostileCommands, NoneOfTenMillionBreaksAPromiseOfTheFilterOrALimitOfTheDevice) {
  const std::unique_ptr<AttackedDevice> attacked = GetParam().make();
  const HostileOutcome outcome = Attack(attacked.get(), 10'000'000, 2);
  for (const auto& [promise, times] : outcome.broken) ADD_FAILURE() << promise << ": " << times << " times";
  EXPECT_GT(outcome.num_acting, outcome.num_samples / 20) << "otherwise a filter that blocks everything would pass";
  EXPECT_GT(outcome.num_braked, 0U);
}

INSTANTIATE_TEST_SUITE_P(Each, HostileCommands, ::testing::ValuesIn(kAttackCases),
                         [](const auto& attack) { return attack.param.name; });

}  // namespace
}  // namespace device_bridge
