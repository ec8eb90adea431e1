// Nodes of a running system are killed during a contact. Real processes, real time.

#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "bus/log/mcap_reader.hpp"
#include "bus/topics.hpp"
#include "core/clock.hpp"
#include "tests/support.hpp"
#include "tools/oos/run/session/session.hpp"

namespace system_tests {
namespace {

constexpr double kZeroWithin_s = 0.060;
constexpr double kFelt_N = 2.5;
constexpr double kSlides_s = 0.6;   // felt for as long: the hand slides on the plate, no press lasts that long
constexpr double kWatched_s = 0.5;  // after a kill that should change no force: others notice it after 0.3 s
constexpr double kLargestJump_N = 0.5;
constexpr int kMostRuns = 3;  // where a machine that stalls spoils some
// After 10 ms without news haptic_node gives no force and device_bridge lets it fade. A loop takes news at its next
// turn, a millisecond later at most.
constexpr double kStall_s = 0.009;
// haptic_node then sets the tool to the hand and moves it out of what it is in, by 0.3 N a millisecond.
constexpr double kRecovery_s = 0.030;

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

// Between two turns of a loop, which should be a millisecond apart.
struct Stall {
  std::string node;
  double from_s = 0.0, to_s = 0.0;  // after the kill
};

struct KilledRun {
  oos::SessionOutcome outcome;
  std::filesystem::path out;
  std::int64_t kill_ns = 0;
  int num_told = 0;  // that it goes on without a picture
  std::vector<ForceSample> forces;
  std::vector<Stall> stalls;
};

// Where a node of those that make the force was silent for so long that others took the force away, by its recording.
std::vector<Stall> ReadStalls(const std::filesystem::path& out, const std::string& role, std::int64_t kill_ns) {
  std::vector<Stall> stalls;
  const std::pair<std::string, std::string> sent_by[] = {{"device_bridge", bus::DeviceStateTopic(role)},
                                                         {"haptic_node", bus::DeviceCommandTopic(role)},
                                                         {"physics_node", bus::kPhysicsStateTopic}};
  for (const auto& [node, topic] : sent_by) {
    std::optional<double> before_s;
    const auto visit = [&](const bus::log::Channel& channel, const bus::log::Message& message) {
      if (channel.topic != topic) return;
      const double t_s = static_cast<double>(static_cast<std::int64_t>(message.publish_time_ns) - kill_ns) * 1e-9;
      if (before_s && t_s - *before_s > kStall_s) stalls.push_back({node, *before_s, t_s});
      before_s = t_s;
    };
    const auto read = bus::log::ReadMcap(oos::RecordingFolder(out) / (node + ".mcap"), visit);
    EXPECT_TRUE(read) << (read ? "" : read.error().detail);
    EXPECT_TRUE(before_s) << node << " recorded no " << topic;
  }
  return stalls;
}

// Runs `touch` and kills the node when the hand feels a force. To watch what the force does then, the run is recorded
// and the kill comes while the hand slides.
KilledRun RunAndKill(const std::string& node, int signal = SIGKILL, bool is_watched = false) {
  KilledRun run;
  run.out = std::filesystem::path(VR_OOS_BINARY_DIR) / "faults" / ((signal == SIGSTOP ? "silence_" : "kill_") + node);
  std::filesystem::remove_all(run.out);
  const scene::Scenario scenario = Load("touch");
  oos::SessionOptions options;
  options.out = run.out;
  options.is_headless = true;
  options.is_recorded = is_watched;
  if (node != "visual_node") options.without = {"visual_node"};
  options.program_folder = std::filesystem::path(VR_OOS_BINARY_DIR) / "bin";
  options.duration_s = 60.0;
  options.say = [&](const std::string& line) { run.num_told += line.find("goes on without its picture") != line.npos; };
  double free_s = 0.0;
  options.while_running = [&](process::Group& group, double seconds, double force_N) {
    if (force_N < kFelt_N) free_s = seconds;
    if (run.kill_ns != 0 || force_N < kFelt_N || (is_watched && seconds - free_s < kSlides_s)) return;
    for (const process::Group::Child& child : group.children()) {
      if (child.name != node) continue;
      kill(child.pid, signal);
      run.kill_ns = core::MonotonicNow_ns();  // after it: this process, too, may be held up
    }
  };
  auto outcome = oos::RunSession(scenario, options);
  EXPECT_TRUE(outcome) << outcome.error().detail;
  if (outcome) run.outcome = *outcome;
  run.forces = ReadForces(run.out);
  if (is_watched) run.stalls = ReadStalls(run.out, scenario.devices[0].role, run.kill_ns);
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

// The largest change from one tick to the next while all loops kept their time, and while one did not.
struct Jumps {
  double in_time_N = 0.0, stalled_N = 0.0;
};

// After the kill. The force of a hand that slides hardly changes, so a large jump comes from a fault or a stall.
Jumps LargestJumps(const KilledRun& run) {
  Jumps jumps;
  for (std::size_t i = 1; i < run.forces.size(); ++i) {
    const double from_s = static_cast<double>(run.forces[i - 1].time_ns - run.kill_ns) * 1e-9;
    const double to_s = static_cast<double>(run.forces[i].time_ns - run.kill_ns) * 1e-9;
    if (to_s < 0.0 || to_s >= kWatched_s) continue;
    const bool is_stalled = std::any_of(run.stalls.begin(), run.stalls.end(), [&](const Stall& stall) {
      return stall.from_s < to_s && from_s < stall.to_s + kRecovery_s;
    });
    double& largest_N = is_stalled ? jumps.stalled_N : jumps.in_time_N;
    largest_N = std::max(largest_N, std::abs(run.forces[i].force_N - run.forces[i - 1].force_N));
  }
  return jumps;
}

bool IsForceKept(const KilledRun& run) {
  const double before_N = LargestForceBetween(run, -0.1, 0.0);
  return before_N > 1.0 && LargestForceBetween(run, 0.1, 0.2) > 0.5 * before_N;
}

// The longest stall that may have changed the force in the watched stretch: after one it takes 0.2 s to return.
const Stall* LongestStall(const KilledRun& run) {
  const Stall* longest = nullptr;
  for (const Stall& stall : run.stalls) {
    if (stall.to_s < -0.3 || stall.from_s > kWatched_s) continue;
    if (longest == nullptr || stall.to_s - stall.from_s > longest->to_s - longest->from_s) longest = &stall;
  }
  return longest;
}

// Whether the run shows what the kill does to the force: not when only a stall can have changed it.
bool IsConclusive(const KilledRun& run) {
  if (run.kill_ns == 0) return false;  // the hand never slid for so long
  const Jumps jumps = LargestJumps(run);
  if (jumps.in_time_N >= kLargestJump_N || LongestStall(run) == nullptr) return true;
  return jumps.stalled_N < kLargestJump_N && IsForceKept(run);
}

// A machine that is busy with something else stops a loop for a moment. So does a kernel that cannot be preempted,
// while it frees the killed node's memory.
KilledRun RunUntilConclusive(const std::string& node) {
  KilledRun run = RunAndKill(node, SIGKILL, true);
  for (int i = 1; i < kMostRuns && !IsConclusive(run); ++i) run = RunAndKill(node, SIGKILL, true);
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

bool IsFelt(const KilledRun& run) {
  return LargestForceBetween(run, -0.02, 0.0) > 1.0;
}

void ExpectForceIsGone(const std::string& node, int signal = SIGKILL) {
  KilledRun run = RunAndKill(node, signal);
  // A stall just before the kill has taken the force away already.
  for (int i = 1; i < kMostRuns && !IsFelt(run); ++i) run = RunAndKill(node, signal);
  EXPECT_TRUE(IsFelt(run)) << "there was no contact to lose";
  EXPECT_GT(NumSamplesAfter(run, kZeroWithin_s), 100u);
  EXPECT_EQ(LargestForceBetween(run, kZeroWithin_s, 10.0), 0.0);
  EXPECT_FALSE(run.outcome.is_final);
  EXPECT_NE(run.outcome.why.find(node), std::string::npos) << run.outcome.why;
  EXPECT_TRUE(IsNamedBy(run, "device_bridge", node));
  ExpectNobodyIsLeft(run);
}

// Skips the test where no run is conclusive.
void ExpectForceIsUnchanged(const KilledRun& run, const std::string& node) {
  ASSERT_NE(run.kill_ns, 0) << run.outcome.why;
  EXPECT_TRUE(IsNamedBy(run, "device_bridge", node));
  EXPECT_TRUE(IsNamedBy(run, "haptic_node", node));
  ExpectNobodyIsLeft(run);
  EXPECT_LT(LargestJumps(run).in_time_N, kLargestJump_N);
  if (!IsConclusive(run)) {
    const Stall& stall = *LongestStall(run);
    GTEST_SKIP() << "this machine stalls: in each run that changed the force; in the last, " << stall.node
                 << " made no turn for " << std::lround(1e3 * (stall.to_s - stall.from_s)) << " ms, from "
                 << std::lround(1e3 * stall.from_s) << " ms after the kill on";
  }
  const double before_N = LargestForceBetween(run, -0.1, 0.0);
  EXPECT_GT(before_N, 1.0) << "there was no contact to keep";
  EXPECT_GT(LargestForceBetween(run, 0.1, 0.2), 0.5 * before_N);
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
  const KilledRun run = RunUntilConclusive("logic_node");
  EXPECT_NE(run.outcome.why.find("logic_node"), std::string::npos) << run.outcome.why;
  ExpectForceIsUnchanged(run, "logic_node");
}
TEST(Faults, KillingTheVisualNodeChangesNoForceAndEndsNoRun) {
  const KilledRun run = RunUntilConclusive("visual_node");
  // A stalled machine can make the operator lose the way: then the run ends long after the kill.
  EXPECT_TRUE(run.outcome.is_final || run.outcome.why.find("no progress") != std::string::npos) << run.outcome.why;
  ASSERT_EQ(run.outcome.dead.size(), 1u);
  EXPECT_NE(run.outcome.dead[0].find("visual_node"), std::string::npos) << run.outcome.dead[0];
  EXPECT_EQ(run.num_told, 1) << "it is said once that the run goes on";
  ExpectForceIsUnchanged(run, "visual_node");
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
