// Nodes of a running system are killed during a contact. Real processes, real time.

#include <gtest/gtest.h>
#include <signal.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/clock.hpp"
#include "tests/support.hpp"
#include "tools/oos/run/session/session.hpp"

namespace system_tests {
namespace {

constexpr double kZeroWithin_s = 0.060;
constexpr double kFelt_N = 3.0;
constexpr double kWatched_s = 0.2;  // after a kill that should change no force
constexpr double kLargestJump_N = 0.5;

struct ForceSample {
  std::int64_t time_ns = 0;
  double force_N = 0.0;
};

// The force commanded to the device at each tick, from the log of device_bridge.
std::vector<ForceSample> ReadForces(const std::filesystem::path& folder) {
  std::ifstream in(folder / "device_bridge_force.csv");
  std::vector<ForceSample> samples;
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::istringstream row(line);
    ForceSample sample;
    char comma = 0;
    int role = 0;
    row >> sample.time_ns >> comma >> role >> comma >> sample.force_N;
    samples.push_back(sample);
  }
  return samples;
}

nlohmann::json ReadJson(const std::filesystem::path& file) {
  std::ifstream in(file);
  return nlohmann::json::parse(in, nullptr, false);
}

struct KilledRun {
  oos::SessionOutcome outcome;
  std::filesystem::path out;
  std::int64_t kill_ns = 0;
  int num_told = 0;  // that it goes on without a picture
  std::vector<ForceSample> forces;
};

// Runs `touch` and kills the node when the hand has felt a force for a while: the operator holds each press for a
// second.
KilledRun RunAndKill(const std::string& node, int signal = SIGKILL) {
  KilledRun run;
  run.out = std::filesystem::path(VR_OOS_BINARY_DIR) / "faults" / ((signal == SIGSTOP ? "silence_" : "kill_") + node);
  std::filesystem::remove_all(run.out);
  const scene::Scenario scenario = Load("touch");
  oos::SessionOptions options;
  options.out = run.out;
  options.is_headless = true;
  if (node != "visual_node") options.without = {"visual_node"};
  options.program_folder = std::filesystem::path(VR_OOS_BINARY_DIR) / "bin";
  options.duration_s = 60.0;
  options.say = [&](const std::string& line) { run.num_told += line.find("goes on without its picture") != line.npos; };
  options.while_running = [&](process::Group& group, double, double force_N) {
    if (run.kill_ns != 0 || force_N < kFelt_N) return;
    for (const process::Group::Child& child : group.children()) {
      if (child.name != node) continue;
      run.kill_ns = core::MonotonicNow_ns();
      kill(child.pid, signal);
    }
  };
  auto outcome = oos::RunSession(scenario, options);
  EXPECT_TRUE(outcome) << outcome.error().detail;
  if (outcome) run.outcome = *outcome;
  run.forces = ReadForces(run.out);
  EXPECT_NE(run.kill_ns, 0);
  return run;
}

double LargestForceBetween(const KilledRun& run, double from_s, double to_s) {
  double largest_N = 0.0;
  for (const ForceSample& sample : run.forces) {
    const double t_s = static_cast<double>(sample.time_ns - run.kill_ns) * 1e-9;
    if (t_s >= from_s && t_s < to_s) largest_N = std::max(largest_N, sample.force_N);
  }
  return largest_N;
}

// Largest change from one tick to the next: the operator presses slowly, so a large one comes from a fault.
double LargestJumpBetween(const KilledRun& run, double from_s, double to_s) {
  double largest_N = 0.0;
  for (std::size_t i = 1; i < run.forces.size(); ++i) {
    const double t_s = static_cast<double>(run.forces[i].time_ns - run.kill_ns) * 1e-9;
    if (t_s < from_s || t_s >= to_s) continue;
    largest_N = std::max(largest_N, std::abs(run.forces[i].force_N - run.forces[i - 1].force_N));
  }
  return largest_N;
}

// A machine that is busy with something else stops the force loop for a moment, and the force jumps when the loop goes
// on. A jump that comes of the kill comes in every run.
KilledRun RunWithoutALateStretch(const std::string& node) {
  constexpr int kRuns = 3;
  KilledRun run = RunAndKill(node);
  for (int i = 1; i < kRuns && LargestJumpBetween(run, 0.0, kWatched_s) >= kLargestJump_N; ++i) run = RunAndKill(node);
  return run;
}

std::size_t NumSamplesAfter(const KilledRun& run, double from_s) {
  std::size_t num = 0;
  for (const ForceSample& sample : run.forces) {
    num += static_cast<double>(sample.time_ns - run.kill_ns) * 1e-9 >= from_s ? 1 : 0;
  }
  return num;
}

bool IsNamedBy(const KilledRun& run, const std::string& witness, const std::string& victim) {
  const nlohmann::json report = ReadJson(run.out / (witness + ".json"));
  if (!report.is_object() || !report.contains("nodes_lost")) return false;
  for (const auto& name : report["nodes_lost"]) {
    if (name.get<std::string>().find(victim) != std::string::npos) return true;
  }
  return false;
}

void ExpectNobodyIsLeft(const KilledRun& run) {
  // Every node carries the run's folder on its command line.
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::ifstream in(entry.path() / "cmdline");
    const std::string words((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    EXPECT_EQ(words.find(run.out.string()), std::string::npos) << "still alive: " << entry.path();
  }
}

void ExpectForceIsGone(const std::string& node, int signal = SIGKILL) {
  const KilledRun run = RunAndKill(node, signal);
  EXPECT_GT(LargestForceBetween(run, -0.02, 0.0), 1.0) << "there was no contact to lose";
  EXPECT_GT(NumSamplesAfter(run, kZeroWithin_s), 100u);
  EXPECT_EQ(LargestForceBetween(run, kZeroWithin_s, 10.0), 0.0);
  EXPECT_FALSE(run.outcome.is_final);
  EXPECT_NE(run.outcome.why.find(node), std::string::npos) << run.outcome.why;
  EXPECT_TRUE(IsNamedBy(run, "device_bridge", node));
  ExpectNobodyIsLeft(run);
}

void ExpectForceIsUnchanged(const KilledRun& run, const std::string& node) {
  const double before_N = LargestForceBetween(run, -0.1, 0.0);
  EXPECT_GT(before_N, 1.0) << "there was no contact to keep";
  EXPECT_GT(LargestForceBetween(run, 0.1, 0.2), 0.5 * before_N);
  EXPECT_LT(LargestJumpBetween(run, 0.0, kWatched_s), kLargestJump_N);
  EXPECT_TRUE(IsNamedBy(run, "device_bridge", node));
  EXPECT_TRUE(IsNamedBy(run, "haptic_node", node));
  ExpectNobodyIsLeft(run);
}

TEST(Faults, KillingTheHapticNodeTakesTheForceAwayWithin60ms) {
  ExpectForceIsGone("haptic_node");
}
TEST(Faults, KillingThePhysicsNodeTakesTheForceAwayWithin60ms) {
  ExpectForceIsGone("physics_node");
}
// A stopped process sends nothing and closes no socket: to its peers it looks like a cut link.
TEST(Faults, CuttingTheLinkToTheHapticNodeTakesTheForceAwayWithin60ms) {
  ExpectForceIsGone("haptic_node", SIGSTOP);
}
TEST(Faults, CuttingTheLinkToThePhysicsNodeTakesTheForceAwayWithin60ms) {
  ExpectForceIsGone("physics_node", SIGSTOP);
}
TEST(Faults, KillingTheLogicNodeChangesNoForce) {
  const KilledRun run = RunWithoutALateStretch("logic_node");
  ExpectForceIsUnchanged(run, "logic_node");
  EXPECT_NE(run.outcome.why.find("logic_node"), std::string::npos) << run.outcome.why;
}
TEST(Faults, KillingTheVisualNodeChangesNoForceAndEndsNoRun) {
  const KilledRun run = RunWithoutALateStretch("visual_node");
  ExpectForceIsUnchanged(run, "visual_node");
  EXPECT_TRUE(run.outcome.is_final) << run.outcome.why;
  ASSERT_EQ(run.outcome.dead.size(), 1u);
  EXPECT_NE(run.outcome.dead[0].find("visual_node"), std::string::npos) << run.outcome.dead[0];
  EXPECT_EQ(run.num_told, 1) << "it is said once that the run goes on";
}

TEST(Faults, ANodeThatCannotBeStartedIsNamedAndNobodyIsLeft) {
  const scene::Scenario scenario = Load("touch");
  oos::SessionOptions options;
  options.out = std::filesystem::path(VR_OOS_BINARY_DIR) / "faults" / "no_program";
  options.without = {"visual_node"};
  options.program_folder = "/nonexistent";
  const auto outcome = oos::RunSession(scenario, options);
  ASSERT_FALSE(outcome);
  EXPECT_NE(outcome.error().detail.find("/nonexistent/physics_node"), std::string::npos) << outcome.error().detail;
}

}  // namespace
}  // namespace system_tests
