// The real nodes in real runs: their step threads neither allocate nor lock nor log once warm.
// tests/step_guard/preload.cpp watches them from inside. Whole procedures are watched in lock-step, in
// acceptance_test.cpp.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support.hpp"
#include "tools/oos/run/session/session.hpp"

namespace system_tests {
namespace {

struct Watched {
  std::uint64_t steps = 0, dirty_steps = 0, allocations = 0, locks = 0, logs = 0;
  std::string where;
};

Watched Read(const std::filesystem::path& file) {
  std::ifstream in(file);
  Watched watched;
  in >> watched.steps >> watched.dirty_steps >> watched.allocations >> watched.locks >> watched.logs;
  std::ostringstream rest;
  rest << in.rdbuf();
  watched.where = rest.str();
  return watched;
}

using Nodes = std::vector<std::string>;

// A machine that stops a node makes the others say that it was away, and this from their loops. How many of such lines
// a node's log has after its start; none when it has any other.
std::uint64_t NumAbsencesTold(const std::filesystem::path& log) {
  std::ifstream in(log);
  std::string line;
  while (std::getline(in, line) && line != "ready") {
  }
  std::uint64_t num = 0;
  while (std::getline(in, line)) {
    bool is_absence = false;
    for (const char* text : {"lost: ", "found: ", ": no command for 60 ms", ": commands arrive again"}) {
      is_absence = is_absence || line.find(text) != std::string::npos;
    }
    if (!is_absence) return 0;
    ++num;
  }
  return num;
}

// Counts of the step threads of `nodes`. logic_node and visual_node are not among them (tests/step_guard/README.md).
void ExpectCleanThreads(const std::filesystem::path& out, const Nodes& nodes) {
  for (const std::string& node : nodes) {
    const Watched watched = Read(out / (node + ".txt"));
    EXPECT_GT(watched.steps, 1000u) << node;
    EXPECT_EQ(watched.locks, 0u) << node << ": the first at\n" << watched.where;
    EXPECT_LE(watched.logs, NumAbsencesTold(out / "run" / (node + ".log"))) << node << ": the first at\n"
                                                                            << watched.where;
    // The simulated operator in device_bridge follows the procedure: STATE with texts, which comes in Wait and
    // allocates, a few times a minute. No device does that.
    const std::uint64_t allowed = node == "device_bridge" ? watched.steps / 1000 : 0;
    EXPECT_LE(watched.dirty_steps, allowed + watched.logs)
        << node << ": " << watched.allocations << " allocations and releases; the first at\n"
        << watched.where;
  }
}

// Ten seconds of a scenario with the nodes watched from inside.
void RunWatched(const std::string& scenario, const std::filesystem::path& out, bool is_colocated) {
  const std::filesystem::path binaries = VR_OOS_BINARY_DIR;
  std::filesystem::remove_all(out);
  std::filesystem::create_directories(out);
  setenv("LD_PRELOAD", (binaries / "tests/step_guard/libstep_guard_preload.so").c_str(), 1);
  setenv("STEP_GUARD_FOLDER", out.c_str(), 1);
  oos::SessionOptions options;
  options.out = out / "run";
  options.is_headless = true;
  options.is_colocated = is_colocated;
  options.without = {"visual_node"};
  options.program_folder = binaries / "bin";
  options.duration_s = 10.0;
  const auto outcome = oos::RunSession(Load(scenario), options);
  unsetenv("LD_PRELOAD");
  ASSERT_TRUE(outcome) << outcome.error().detail;
}

void ExpectCleanRun(const std::string& scenario, const std::filesystem::path& out, bool is_colocated,
                    const Nodes& nodes) {
  RunWatched(scenario, out, is_colocated);
  ExpectCleanThreads(out, nodes);
}

class StepThreads : public testing::Test {
 protected:
  void SetUp() override {
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
    GTEST_SKIP() << "sanitizers have an allocator of their own";
#endif
  }
  const std::filesystem::path folder_ = std::filesystem::path(VR_OOS_BINARY_DIR) / "step_guard";
};

TEST_F(StepThreads, NeitherAllocateNorLockNorLogOnceWarmInAnyScenario) {
  // free_collision has no hand, and ends before its nodes are warm.
  for (const std::string name : {"touch", "service_robot", "peg_in_hole", "module_replacement", "two_hands"}) {
    SCOPED_TRACE(name);
    ExpectCleanRun(name, folder_ / name, false, {"device_bridge", "haptic_node", "physics_node"});
  }
}

// Free parts; mechanisms and a sheet; two hands.
TEST_F(StepThreads, NeitherAllocateNorLockNorLogWithHapticAndPhysicsInOneProcess) {
  for (const std::string name : {"touch", "module_replacement", "two_hands"}) {
    SCOPED_TRACE(name);
    ExpectCleanRun(name, folder_ / (name + "_colocated"), true, {"device_bridge", "haptic_physics_node"});
  }
}

}  // namespace
}  // namespace system_tests
