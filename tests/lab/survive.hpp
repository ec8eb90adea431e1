#pragma once

#include <signal.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <sstream>

#include "scene/load_scenario.hpp"
#include "tests/lab/lab_support.hpp"
#include "tests/support/bus_watch.hpp"

namespace system_tests {

// The force commanded to the device in a tick, from the log of device_bridge; times by the test's clock.
struct GivenForce {
  std::int64_t time_ns = 0;
  double force_N = 0.0;
};

inline double Since_s(std::int64_t since_ns) {
  return static_cast<double>(core::MonotonicNow_ns() - since_ns) * 1e-9;
}

// Tests that injure a run of `touch` on three machines and check the force commanded to the hand.
class SurviveTest : public LabTest {
 protected:
  static constexpr double kFelt_N = 3.0;
  static constexpr double kZeroWithin_s = 0.060;

  void StartRun(const std::string& name, std::vector<std::string> more = {"--without", "visual_node"},
                const std::string& lab_file = "") {
    out_ = Folder(name);
    more.insert(more.end(), {"--out", out_.string()});
    lab_ = lab_file.empty() ? WriteLab(name, OnThree()) : lab_file;
    auto launcher = process::PipedChild::Start(Launch(lab_, more));
    ASSERT_TRUE(launcher) << launcher.error().detail;
    launcher_ = std::move(*launcher);
    ASSERT_TRUE(WaitFor(launcher_.get(), "nodes are ready")) << launcher_->out() << launcher_->err();
    watch_ = std::make_unique<BusWatch>("/proc/" + FirstWord(machines_->folder() / "launcher.pid") + "/ns/net",
                                        "10.77.0.1", "right");
    ASSERT_EQ(watch_->trouble(), "");
  }

  // Waits until the condition holds; false if it does not in time, or the run has ended.
  bool Until(const std::function<bool()>& holds, double patience_s = 30.0) {
    const std::int64_t begin_ns = core::MonotonicNow_ns();
    while (!holds()) {
      launcher_->Poll();
      if (Since_s(begin_ns) > kSlowness * patience_s || launcher_->has_ended()) return false;
      process::WaitForAny({launcher_.get()}, 1);
    }
    return true;
  }
  // Waits until a force on the hand has lasted for `lasting_s` without a gap.
  bool UntilFelt(double lasting_s = 0.15) {
    std::int64_t since_ns = 0;
    return Until(
        [&] {
          if (watch_->force_N() < kFelt_N)
            since_ns = 0;
          else if (since_ns == 0)
            since_ns = core::MonotonicNow_ns();
          return since_ns != 0 && Since_s(since_ns) > lasting_s;
        },
        40.0);
  }

  // The same for a contact that has only just begun, so that the operator will not end it soon.
  bool UntilFeltAnew(double lasting_s) {
    return Until([&] { return watch_->force_N() < kFelt_N; }, 40.0) && UntilFelt(lasting_s);
  }

  // Process ids, outside the machine, of its processes of that program (and verb, of `oos`), the oldest first.
  static std::vector<pid_t> FindAll(const std::string& machine, const std::string& program,
                                    const std::string& verb = "") {
    std::vector<pid_t> all;
    const std::string word = verb.empty() ? std::string() : '\0' + verb;
    std::error_code error;
    const auto keeper = "/proc/" + FirstWord(machines_->folder() / (machine + ".pid"));
    const auto space = std::filesystem::read_symlink(keeper + "/ns/pid", error);
    for (const auto& entry : std::filesystem::directory_iterator("/proc", error)) {
      const auto its = std::filesystem::read_symlink(entry.path() / "ns/pid", error);
      if (error || its != space) continue;
      const auto exe = std::filesystem::read_symlink(entry.path() / "exe", error);
      std::ifstream in(entry.path() / "cmdline");
      std::string words{std::istreambuf_iterator<char>(in), {}};
      if (exe.filename() != program || words.find(word) == std::string::npos) continue;
      all.push_back(std::stoi(entry.path().filename().string()));
    }
    std::sort(all.begin(), all.end());
    return all;
  }
  // The first of them; 0: none.
  static pid_t Find(const std::string& machine, const std::string& program, const std::string& verb = "") {
    const std::vector<pid_t> all = FindAll(machine, program, verb);
    return all.empty() ? 0 : all.front();
  }

  // Sends SIGKILL; returns the time. The clock is read afterwards, so that a delay of the test in between does not
  // count against the node.
  static std::int64_t Kill(pid_t process) {
    EXPECT_GT(process, 0) << "there is no process to kill";
    if (process > 0) kill(process, SIGKILL);
    return core::MonotonicNow_ns();
  }

  // Whether a live peer has that name and another instance id than `instance`: the node was restarted.
  [[nodiscard]] bool IsBack(const std::string& node, std::uint64_t instance) const {
    for (const bus::PeerStatus& peer : watch_->peers()) {
      if (peer.name == node) return peer.is_alive && !peer.is_stalled && peer.instance != instance;
    }
    return false;
  }
  [[nodiscard]] std::uint64_t InstanceOf(const std::string& node) const {
    for (const bus::PeerStatus& peer : watch_->peers()) {
      if (peer.name == node) return peer.instance;
    }
    return 0;
  }

  // Waits for the run's end and checks what always holds: completed, no process left, no sample above cap or rate.
  void FinishRun(double patience_s = 120.0) {
    watch_.reset();
    WaitForEnd(launcher_.get(), patience_s);
    EXPECT_EQ(launcher_->status(), 0) << launcher_->out() << launcher_->err();
    ExpectNothingIsLeft();
    ReadForces();
    ExpectEverySampleIsWithinLimits();
  }

  void ReadForces() {
    std::ifstream in(out_ / "device_bridge_force.csv");
    std::string line;
    std::getline(in, line);
    while (std::getline(in, line)) {
      std::istringstream row(line);
      GivenForce sample;
      char comma = 0;
      int role = 0;
      row >> sample.time_ns >> comma >> role >> comma >> sample.force_N;
      sample.time_ns -= ClockOf("alpha");
      forces_.push_back(sample);
    }
    EXPECT_GT(forces_.size(), 1000u) << "the bridge left no log";
  }

  void ExpectEverySampleIsWithinLimits() {
    const auto scenario = scene::LoadScenario(std::string(VR_OOS_SOURCE_DIR) + "/scenarios/touch");
    ASSERT_TRUE(scenario);
    const scene::Device& device = scenario->devices[0];
    const double cap_N = std::min(device.max_force_N, scenario->force_cap_N);
    double largest_N = 0.0, fastest_N_per_s = 0.0;
    for (std::size_t i = 1; i < forces_.size(); ++i) {
      const double dt_s = 1e-9 * static_cast<double>(forces_[i].time_ns - forces_[i - 1].time_ns);
      largest_N = std::max(largest_N, forces_[i].force_N);
      // The filter limits the change per nominal tick or longer. A tick after a late one is shorter than nominal.
      const double step_N = std::abs(forces_[i].force_N - forces_[i - 1].force_N);
      fastest_N_per_s = std::max(fastest_N_per_s, step_N / std::max(dt_s, core::kTick_s));
    }
    EXPECT_LE(largest_N, cap_N * (1.0 + 1e-6));
    EXPECT_LE(fastest_N_per_s, device.max_force_rate_N_per_s * (1.0 + 1e-6));
    std::printf("  %zu samples: at most %.1f N (cap %.0f), %.0f N/s (limit %.0f)\n", forces_.size(), largest_N, cap_N,
                fastest_N_per_s, device.max_force_rate_N_per_s);
  }

  // Over the samples between two times, in seconds after `zero_ns`.
  [[nodiscard]] double LargestForce_N(std::int64_t zero_ns, double from_s, double to_s) const {
    double largest_N = 0.0;
    for (const GivenForce& sample : forces_) {
      const double t_s = 1e-9 * static_cast<double>(sample.time_ns - zero_ns);
      if (t_s >= from_s && t_s < to_s) largest_N = std::max(largest_N, sample.force_N);
    }
    return largest_N;
  }
  // When the force became zero after `zero_ns`, and when it returned [s]; negative if it did not.
  [[nodiscard]] double GoneAfter_s(std::int64_t zero_ns) const {
    for (const GivenForce& sample : forces_) {
      if (sample.time_ns > zero_ns && sample.force_N == 0.0)
        return 1e-9 * static_cast<double>(sample.time_ns - zero_ns);
    }
    return -1.0;
  }
  [[nodiscard]] double BackAfter_s(std::int64_t zero_ns) const {
    bool was_gone = false;
    for (const GivenForce& sample : forces_) {
      if (sample.time_ns < zero_ns) continue;
      was_gone = was_gone || sample.force_N == 0.0;
      if (was_gone && sample.force_N > 0.1) return 1e-9 * static_cast<double>(sample.time_ns - zero_ns);
    }
    return -1.0;
  }

  // The force is gone in time, and stays so until the node is back.
  void ExpectForceFades(const std::string& what, std::int64_t hit_ns, double until_s) const {
    EXPECT_GT(LargestForce_N(hit_ns, -0.02, 0.0), 1.0) << what << ": there was no contact to lose";
    EXPECT_EQ(LargestForce_N(hit_ns, kZeroWithin_s, until_s), 0.0) << what;
    std::printf("  %s: force zero after %.0f ms, felt again after %.2f s\n", what.c_str(), 1e3 * GoneAfter_s(hit_ns),
                BackAfter_s(hit_ns));
  }
  // A force that fades is zero after 60 ms, and a contact that has only just begun lasts longer than the 120 ms
  // checked.
  void ExpectForceStays(const std::string& what, std::int64_t hit_ns) const {
    const double before_N = LargestForce_N(hit_ns, -0.1, 0.0);
    EXPECT_GT(before_N, 1.0) << what << ": there was no contact to keep";
    double least_N = before_N;
    for (const GivenForce& sample : forces_) {
      const double t_s = 1e-9 * static_cast<double>(sample.time_ns - hit_ns);
      if (t_s >= 0.0 && t_s < 2.0 * kZeroWithin_s) least_N = std::min(least_N, sample.force_N);
    }
    EXPECT_GT(least_N, 0.05 * before_N) << what;
    std::printf("  %s: %.1f N before, %.1f N at least in the %.0f ms after\n", what.c_str(), before_N, least_N,
                2e3 * kZeroWithin_s);
  }

  void ExpectSaid(const std::string& text) const {
    EXPECT_NE(launcher_->out().find(text), std::string::npos) << "the launcher did not print '" << text << "':\n"
                                                              << launcher_->out();
  }
  void ExpectShown(const std::string& text) const {
    std::string all;
    for (const std::string& hint : watch_->hints()) all += hint + "\n";
    EXPECT_NE(all.find(text), std::string::npos) << "the screen never said '" << text << "', but\n" << all;
  }

  std::filesystem::path out_;
  std::string lab_;
  std::unique_ptr<process::PipedChild> launcher_;
  std::unique_ptr<BusWatch> watch_;
  std::vector<GivenForce> forces_;
};

}  // namespace system_tests
