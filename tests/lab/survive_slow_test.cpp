// Every failure of docs/reference/survival.md, in runs on three machines. The force commanded to the hand is read from
// the log of device_bridge, a sample every millisecond; the procedure must complete afterwards.

#include <gmock/gmock.h>

#include <set>

#include "tests/lab/survive.hpp"

namespace system_tests {
namespace {

using testing::HasSubstr;

std::string MachineOf(const std::string& node) {
  if (node == "visual_node") return "gamma";
  return node == "physics_node" || node == "logic_node" ? "beta" : "alpha";
}

enum class Blow { kKill, kStop, kSlow };

void PrintTo(Blow blow, std::ostream* out) {
  *out << (blow == Blow::kKill ? "kill -9" : blow == Blow::kStop ? "stopped for 1 s" : "half as fast for 1 s");
}

// For `seconds` the process runs only in the first 5 of every 10 ms.
void SlowDown(pid_t process, double seconds) {
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  const timespec pause{0, 5'000'000};
  while (Since_s(begin_ns) < seconds) {
    kill(process, SIGSTOP);
    nanosleep(&pause, nullptr);  // the blow itself, not a wait
    kill(process, SIGCONT);
    nanosleep(&pause, nullptr);
  }
}

class SurviveBlow : public SurviveTest, public testing::WithParamInterface<Blow> {
 protected:
  // Applies the blow; returns the time, as Kill does.
  static std::int64_t Stop(pid_t process) {
    kill(process, SIGSTOP);
    return core::MonotonicNow_ns();
  }
  // Seconds from `since_ns` until a node on the bus found it again; until now if none had lost it.
  [[nodiscard]] double FoundAfter_s(const std::string& node, std::int64_t since_ns) const {
    for (const BusWatch::Heard& one : watch_->heard()) {
      if (one.event.name != "node_found" || one.event.detail != node || one.time_ns < since_ns) continue;
      return 1e-9 * static_cast<double>(one.time_ns - since_ns);
    }
    return Since_s(since_ns);
  }
  // Returns when.
  std::int64_t Hit(const std::string& node) {
    const pid_t process = Find(MachineOf(node), node);
    EXPECT_GT(process, 0) << node;
    if (process <= 0) return 0;
    const std::uint64_t instance = InstanceOf(node);
    if (GetParam() == Blow::kSlow) {
      const std::int64_t begin_ns = core::MonotonicNow_ns();
      SlowDown(process, 1.0);
      return begin_ns;
    }
    const std::int64_t hit_ns = GetParam() == Blow::kKill ? Kill(process) : Stop(process);
    if (GetParam() == Blow::kStop) {
      Until([&] { return Since_s(hit_ns) > 1.0; });
      kill(process, SIGCONT);
    }
    EXPECT_TRUE(Until([&] { return IsBack(node, GetParam() == Blow::kKill ? instance : 0); })) << launcher_->out();
    const double back_s = FoundAfter_s(node, hit_ns);
    std::printf("  %s, %s: back after %.2f s\n", node.c_str(), testing::PrintToString(GetParam()).c_str(), back_s);
    const bool is_force = node == "haptic_node" || node == "physics_node";
    if (GetParam() == Blow::kKill && is_force) {
      EXPECT_LE(back_s, 1.0) << node;
    }
    return hit_ns;
  }
};

// device_bridge first: its restart begins a new log of forces, which the checks of the others read.
TEST_P(SurviveBlow, EachNodeRecovers) {
  StartRun("survive_blow_" + std::to_string(static_cast<int>(GetParam())), {});
  if (HasFatalFailure()) return;
  std::map<std::string, std::int64_t> hits_ns;
  for (const std::string node : {"device_bridge", "logic_node", "visual_node", "haptic_node", "physics_node"}) {
    const bool costs_no_force = node == "logic_node" || node == "visual_node";
    ASSERT_TRUE(costs_no_force ? UntilFeltAnew(0.12) : UntilFelt(0.12)) << "before " << node << "\n"
                                                                        << launcher_->out();
    hits_ns[node] = Hit(node);
  }
  if (GetParam() != Blow::kSlow) {
    for (const char* node : {"device_bridge", "haptic_node", "physics_node", "visual_node"}) {
      ExpectShown(std::string(node) + " is lost");
    }
  }
  FinishRun();
  for (const char* node : {"logic_node", "visual_node"}) ExpectForceStays(node, hits_ns[node]);
  if (GetParam() == Blow::kSlow) return;  // the force may fade and return; Finish has checked its limits
  for (const char* node : {"haptic_node", "physics_node"}) ExpectForceFades(node, hits_ns[node], 0.3);
}

INSTANTIATE_TEST_SUITE_P(, SurviveBlow, testing::Values(Blow::kKill, Blow::kStop, Blow::kSlow), [](const auto& one) {
  return one.param == Blow::kKill ? "Kill" : one.param == Blow::kStop ? "Stop" : "Slow";
});

class SurviveSlow : public SurviveTest {};

TEST_F(SurviveSlow, KilledPhysicsComesBackInTimeAndNineOfTenProceduresComplete) {
  const std::vector<std::string> steps = {"press", "slide", "edge", "push_block"};
  int num_finished = 0;
  std::vector<double> back_s, gone_s;
  for (int attempt = 0; attempt < 10; ++attempt) {
    SCOPED_TRACE(attempt);
    forces_.clear();
    StartRun("survive_ten", {"--without", "visual_node", "--seed", std::to_string(attempt + 1)});
    if (HasFatalFailure()) return;
    const std::string& step = steps[static_cast<std::size_t>(attempt) % steps.size()];
    ASSERT_TRUE(Until([&] { return watch_->step() == step; }, 60.0)) << launcher_->out();
    ASSERT_TRUE(UntilFelt()) << launcher_->out();
    const std::int64_t killed_ns = Kill(Find("beta", "physics_node"));
    ASSERT_TRUE(Until([&] { return watch_->physics_heard_ns() > killed_ns + 50'000'000; }, 20.0)) << launcher_->out();
    back_s.push_back(1e-9 * static_cast<double>(watch_->physics_heard_ns() - killed_ns));
    watch_.reset();
    WaitForEnd(launcher_.get(), 120.0);
    num_finished += launcher_->status() == 0 ? 1 : 0;
    if (launcher_->status() != 0) std::printf("%s\n", launcher_->out().c_str());
    ExpectNothingIsLeft();
    ReadForces();
    ExpectEverySampleIsWithinLimits();
    ExpectForceFades("in step " + step, killed_ns, 0.3);
    gone_s.push_back(GoneAfter_s(killed_ns));
  }
  std::sort(back_s.begin(), back_s.end());
  std::sort(gone_s.begin(), gone_s.end());
  std::printf("%d of 10 finished; force zero after %.0f ms at most; back after %.2f s in the median, %.2f s at most\n",
              num_finished, 1e3 * gone_s.back(), back_s[5], back_s.back());
  EXPECT_GE(num_finished, 9);
  EXPECT_LE(back_s.back(), 1.0);
}

TEST_F(SurviveSlow, KillingTheRegistryChangesNoForce) {
  StartRun("survive_registry");
  if (HasFatalFailure()) return;
  ASSERT_TRUE(UntilFelt(0.12));
  const pid_t registry = Find("beta", "oos", "registry");
  ASSERT_GT(registry, 0);
  const std::int64_t hit_ns = Kill(registry);
  ASSERT_TRUE(Until([&] {
    const pid_t again = Find("beta", "oos", "registry");
    return again != 0 && again != registry;
  }));
  FinishRun();
  ExpectForceStays("registry, SIGKILL", hit_ns);
  ExpectSaid("exited: registry (terminated by SIGKILL; not expected)");
}

TEST_F(SurviveSlow, KillingTheLauncherChangesNothingAndAnyTerminalCanCleanUp) {
  StartRun("survive_launcher");
  if (HasFatalFailure()) return;
  ASSERT_TRUE(UntilFelt(0.12));
  const std::int64_t hit_ns = Kill(launcher_->pid());
  WaitForEnd(launcher_.get());
  EXPECT_TRUE(watch_->WaitUntilFinal(60.0)) << "in step " << watch_->step();
  watch_.reset();
  const process::Answer stop = Run(Oos({"stop", "--lab", lab_}));
  EXPECT_EQ(stop.status, 0) << stop.out << stop.err;
  ExpectNothingIsLeft();
  ReadForces();
  ExpectEverySampleIsWithinLimits();
  ExpectForceStays("launcher, SIGKILL", hit_ns);
}

// The run writes to a separate disk on the recorder's machine, and the test fills that disk.
TEST_F(SurviveSlow, AFullDiskCostsOnlyTheRecording) {
  const std::string lab = WriteLab("survive_disk", OnThree(), "run_folder=\"/mnt/vr_oos\"", "min_free_MB=\"1\"");
  for (const char* machine : {"alpha", "beta", "gamma"}) {
    const process::Answer made = Run(machines_->On(
        machine, {"sh", "-c", "mountpoint -q /mnt || mount -t tmpfs -o size=400m tmpfs /mnt; mkdir -p /mnt/vr_oos"}));
    ASSERT_EQ(made.status, 0) << made.err;
  }
  const std::filesystem::path recorded = Folder("survive_disk_recorded");
  StartRun("survive_disk", {"--without", "visual_node", "--record", recorded.string()}, lab);
  if (HasFatalFailure()) return;
  // All but 40 MB are filled beforehand, so that the rest takes milliseconds and the disk gets full during a contact.
  const process::Answer most = Run(machines_->On(
      "beta",
      {"sh", "-c",
       "free_kB=$(df -k --output=avail /mnt | tail -n 1); fallocate -l $(((free_kB - 40000) * 1024)) /mnt/most"}));
  ASSERT_EQ(most.status, 0) << most.err;
  ASSERT_TRUE(UntilFelt(0.12));
  const std::size_t said_before = launcher_->out().size();
  const process::Answer rest = Run(machines_->On("beta", {"sh", "-c", "cat /dev/zero >/mnt/rest"}));
  const std::int64_t full_ns = core::MonotonicNow_ns();
  EXPECT_NE(rest.status, 0);
  EXPECT_THAT(rest.err, HasSubstr("No space left on device"));

  ASSERT_TRUE(Until([&] { return Since_s(full_ns) > 3.0; }));
  const std::string said = launcher_->out().substr(said_before);
  EXPECT_THAT(said, HasSubstr("exited: recorder"));
  EXPECT_THAT(said, testing::ContainsRegex("checkpoint .*/physics_node.checkpoint: cannot be written"));
  EXPECT_THAT(said, HasSubstr("logic_node.checkpoint cannot be written"));
  EXPECT_THAT(said, testing::Not(HasSubstr("force_faded")));

  const auto room_again = std::filesystem::file_time_type::clock::now();
  Run(machines_->On("beta", {"rm", "/mnt/most", "/mnt/rest"}));
  FinishRun();
  ExpectForceStays("disk full", full_ns);
  for (const char* node : {"physics_node", "logic_node"}) {
    EXPECT_GT(std::filesystem::last_write_time(out_ / (std::string(node) + ".checkpoint")), room_again) << node;
  }
  EXPECT_GT(std::filesystem::file_size(recorded / "run.mcap"), 0u);
  std::uintmax_t second_part_bytes = 0;  // tries for which there was no room left empty files
  for (const auto& entry : std::filesystem::directory_iterator(recorded)) {
    const bool is_later = entry.path().filename().string().rfind("run-", 0) == 0;
    if (is_later) second_part_bytes = std::max(second_part_bytes, entry.file_size());
  }
  EXPECT_GT(second_part_bytes, 1'000'000u) << launcher_->out();
}

class SurviveReboot : public SurviveTest, public testing::WithParamInterface<const char*> {};

TEST_P(SurviveReboot, TheHostsNodesComeBackAndTheProcedureCompletes) {
  const std::string machine = GetParam();
  StartRun("survive_reboot_" + machine, {});
  if (HasFatalFailure()) return;
  ASSERT_TRUE(UntilFelt(0.12));
  const pid_t first_process = std::stoi(FirstWord(machines_->folder() / (machine + ".pid")));
  const std::int64_t clock_ns = ClockOf("alpha");
  const std::int64_t hit_ns = Kill(first_process);
  ASSERT_TRUE(WaitFor(launcher_.get(), "host " + machine + " is back")) << launcher_->out();
  std::printf("  %s is back after %.2f s\n", machine.c_str(), Since_s(hit_ns));
  FinishRun(240.0);
  // The bridge's clock began anew with its machine.
  if (machine == "alpha") {
    EXPECT_NE(ClockOf("alpha"), clock_ns);
  }
  if (machine == "beta") ExpectForceFades("beta is switched off", hit_ns, 0.5);
  if (machine == "gamma") ExpectForceStays("gamma is switched off", hit_ns);
}

INSTANTIATE_TEST_SUITE_P(, SurviveReboot, testing::Values("alpha", "beta", "gamma"),
                         [](const auto& one) { return std::string(one.param); });

// Machines whose links a program delays and cuts.
class SurviveLink : public SurviveTest {
 protected:
  static void SetUpTestSuite() {
    if (access("/dev/net/tun", R_OK | W_OK) != 0) {
      why_not_ = "this kernel has no TAP devices (/dev/net/tun)";
      return;
    }
    setenv("MACHINES_RELAY", VR_OOS_BINARY_DIR "/bin/lab_relay", 1);
    LabTest::SetUpTestSuite();
    unsetenv("MACHINES_RELAY");
  }
  static void SetLink(const std::string& figures) {
    const auto file = machines_->folder() / "link", beside = machines_->folder() / "link.new";
    std::ofstream(beside) << figures << "\n";
    std::filesystem::rename(beside, file);
  }
  // The texts that a unit printed, in order, from the launcher's lines "... [HOST] UNIT: TEXT".
  [[nodiscard]] std::vector<std::string> SaidBy(const std::string& unit, const std::vector<std::string>& words) const {
    std::vector<std::string> said;
    std::istringstream lines(launcher_->out());
    for (std::string line; std::getline(lines, line);) {
      if (line.find("] " + unit + ": ") == std::string::npos) continue;
      for (const std::string& word : words) {
        if (line.find(word) != std::string::npos) said.push_back(word);
      }
    }
    return said;
  }
};

TEST_F(SurviveLink, PulledForHalfASecondThenLosing5PercentWithJitter) {
  SetLink("0 0 0");
  StartRun("survive_link", {"--without", "visual_node"});
  if (HasFatalFailure()) return;
  ASSERT_TRUE(UntilFelt(0.12));
  SetLink("0 0 0 beta");
  const std::int64_t hit_ns = core::MonotonicNow_ns() + 2'000'000;  // the relay reads its settings every 2 ms
  ASSERT_TRUE(Until([&] { return Since_s(hit_ns) > 0.5; }));
  SetLink("0.2 1.0 5");
  ASSERT_TRUE(Until([&] { return watch_->step() == "push_block"; }, 90.0)) << launcher_->out();
  FinishRun(180.0);
  // EVENT arrives in order and complete: the bridge's events in its own log equal those that the registry received.
  const auto written = SaidBy("device_bridge", {"no command for 60 ms", "commands arrive again"});
  const auto heard = SaidBy("bus", {"no command for 60 ms", "commands arrive again"});
  EXPECT_GE(written.size(), 2u);
  EXPECT_EQ(heard, written);
  EXPECT_EQ(SaidBy("bus", {"step_entered press", "step_entered slide", "step_entered edge", "step_entered push_block"}),
            (std::vector<std::string>{"step_entered press", "step_entered slide", "step_entered edge",
                                      "step_entered push_block"}));
  std::printf("  %zu events of the bridge heard in order\n", heard.size());
  ExpectForceFades("beta's link is pulled", hit_ns, 0.45);
}

}  // namespace
}  // namespace system_tests
