// A hand with five fingers, scripted, with all nodes: docs/decisions/0024-fingers-are-bodies.md.

#include <gtest/gtest.h>

#include <algorithm>

#include "nodes/lockstep/replay_steps.hpp"
#include "tests/support.hpp"

namespace system_tests {
namespace {

// Its procedure: lifted; ten seconds later still up; gripped half as hard it falls.
TEST(FiveFingers, HoldHalfAKilogramForTenSecondsAndDropItAtHalfTheGrip) {
  for (const char* file : {"five_fingers", "five_fingers/left.xml"}) {
    const scene::Scenario scenario = Load(file);
    const auto block = static_cast<std::size_t>(scenario.FindObject("block"));
    double last_m = 1.0;
    double highest_m = 0.0;
    lockstep::Options options;
    options.follow = [&](const core::PhysicsState& state) {
      for (const core::BodyState& body : state.bodies) {
        if (body.object != block) continue;
        highest_m = std::max(highest_m, body.X_WO.translation.z);
        last_m = body.X_WO.translation.z;
      }
    };
    const lockstep::Outcome outcome = InLockstep(scenario, options);
    EXPECT_TRUE(outcome.is_completed) << file << ": " << outcome.why;
    ASSERT_EQ(outcome.steps.size(), 3U) << file;
    EXPECT_EQ(outcome.steps[1].name, "hold");
    EXPECT_NEAR(outcome.steps[1].seconds, 10.0, 0.1) << file;
    EXPECT_GT(highest_m, 0.125) << file;
    EXPECT_LT(last_m, 0.06) << file;
  }
}

TEST(FiveFingers, AreTheSameBitForBitInEachRunAndInReplay) {
  const auto file = std::filesystem::path(::testing::TempDir()) / "five_fingers.mcap";
  std::filesystem::remove(file);  // of a run that was killed
  const scene::Scenario scenario = Load("five_fingers");
  lockstep::Options options;
  options.duration_s = 6.0;
  options.steps = file;
  const lockstep::Outcome first = InLockstep(scenario, options);
  options.steps.clear();
  options.workers = 2;
  EXPECT_EQ(first.hash, InLockstep(scenario, options).hash);
  const auto nodes = lockstep::ReadRecordedNodes(file);
  ASSERT_TRUE(nodes);
  EXPECT_GE(nodes->size(), 3U);
  for (const lockstep::RecordedNode& node : *nodes) {
    const auto outcome = lockstep::ReplaySteps(file, node, scenario, {});
    ASSERT_TRUE(outcome) << node.node << ": " << outcome.error().detail;
    EXPECT_GT(outcome->num_steps, 100U) << node.node;
    EXPECT_EQ(outcome->num_inexact, 0U) << node.node;
  }
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace system_tests
