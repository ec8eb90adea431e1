// The failure that costs the operator most, among the fast tests. The others are in survive_slow_test.cpp;
// docs/reference/survival.md describes what the operator notices of each.

#include "tests/lab/survive.hpp"

namespace system_tests {
namespace {

class Survive : public SurviveTest {};

TEST_F(Survive, KilledPhysicsTakesTheForceAwayWithin60msAndComesBackFromItsCheckpoint) {
  StartRun("survive_physics");
  if (HasFatalFailure()) return;
  ASSERT_TRUE(UntilFelt()) << launcher_->out();
  const pid_t physics = Find("beta", "physics_node");
  const std::uint64_t tick = watch_->physics_tick();
  ASSERT_GT(physics, 0);
  ASSERT_GT(tick, 0u);
  const std::int64_t killed_ns = Kill(physics);
  ASSERT_TRUE(Until([&] { return watch_->physics_heard_ns() > killed_ns + 50'000'000; }, 20.0)) << launcher_->out();
  const double back_s = 1e-9 * static_cast<double>(watch_->physics_heard_ns() - killed_ns);
  EXPECT_GT(watch_->physics_tick() + 1000, tick) << "it started from the beginning, not from a checkpoint";
  FinishRun();
  ExpectForceFades("physics_node, SIGKILL", killed_ns, 0.3);
  std::printf("  physics_node is back after %.2f s\n", back_s);
  ExpectSaid("physics_node: goes on from tick");
}

}  // namespace
}  // namespace system_tests
