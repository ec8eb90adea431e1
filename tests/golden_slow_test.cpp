// A hundred replays of the golden recording at each of three speeds.

#include <gtest/gtest.h>

#include <set>
#include <thread>

#include "tests/golden.hpp"

namespace system_tests {
namespace {

constexpr int kRepetitions = 100;

std::set<std::uint64_t> DigestsOf(const lockstep::RecordedNode& recorded, const scene::Scenario& scenario,
                                  double speed) {
  std::set<std::uint64_t> digests;
  for (int i = 0; i < kRepetitions; ++i) {
    lockstep::StepsOptions options;
    options.speed = speed;
    const auto outcome = lockstep::ReplaySteps(GoldenFile(), recorded, scenario, options);
    digests.insert(outcome ? outcome->digest : 0);
  }
  return digests;
}

TEST(Golden, AHundredReplaysAtThreeSpeedsHaveOneDigest) {
  const scene::Scenario scenario = Load("module_replacement/paper.xml");
  for (const char* node : {"logic_node", "physics_node", "haptic_node"}) {
    const lockstep::RecordedNode recorded = GoldenNode(node);
    std::set<std::uint64_t> digests[3];
    std::vector<std::thread> threads;
    // Side by side: at the recording's own speed a replay mostly waits.
    for (const auto& [slot, speed] : {std::pair{0, 0.0}, std::pair{1, 10.0}, std::pair{2, 1.0}}) {
      threads.emplace_back([&, slot = slot, speed = speed] { digests[slot] = DigestsOf(recorded, scenario, speed); });
    }
    for (std::thread& thread : threads) thread.join();
    for (const std::set<std::uint64_t>& some : digests) {
      EXPECT_EQ(some.size(), 1U) << node;
      EXPECT_EQ(some, digests[0]) << node;
      EXPECT_NE(*some.begin(), 0U) << node << " could not be replayed";
    }
  }
}

}  // namespace
}  // namespace system_tests
