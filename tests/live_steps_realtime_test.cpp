// Steps that were recorded by running processes, replayed without them.

#include <gtest/gtest.h>

#include <cstdio>

#include "nodes/lockstep/replay_steps.hpp"
#include "tests/support.hpp"
#include "tools/oos/run/session/session.hpp"

namespace system_tests {
namespace {

TEST(LiveSteps, OfRunningNodesReplayBitForBit) {
  const std::filesystem::path out = std::filesystem::path(VR_OOS_BINARY_DIR) / "live_steps";
  std::filesystem::remove_all(out);
  std::filesystem::create_directories(out / "steps");
  const scene::Scenario scenario = Load("touch");
  oos::SessionOptions options;
  options.out = out;
  options.steps = out / "steps";
  options.is_headless = true;
  options.without = {"visual_node"};
  options.program_folder = std::filesystem::path(VR_OOS_BINARY_DIR) / "bin";
  options.duration_s = 5.0;
  ASSERT_TRUE(oos::RunSession(scenario, options));
  for (const std::string node : {"logic_node", "physics_node", "haptic_node"}) {
    const std::filesystem::path file = options.steps / (node + ".mcap");
    const auto recorded = lockstep::ReadRecordedNodes(file);
    ASSERT_TRUE(recorded) << recorded.error().detail;
    ASSERT_EQ(recorded->size(), 1U);
    const auto outcome = lockstep::ReplaySteps(file, recorded->front(), scenario, {});
    if (!outcome && outcome.error().detail.find("time ran short") != std::string::npos) {
      std::printf("%s: %s\n", node.c_str(), outcome.error().detail.c_str());  // a busy machine: reported, no failure
      continue;
    }
    ASSERT_TRUE(outcome) << outcome.error().detail;
    EXPECT_GT(outcome->num_steps, 100U);
    EXPECT_EQ(outcome->num_inexact, 0U) << lockstep::Describe(recorded->front(), *outcome);
  }
}

}  // namespace
}  // namespace system_tests
