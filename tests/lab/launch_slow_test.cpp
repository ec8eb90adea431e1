// Launches that take minutes: many starts, the whole procedure, launchers that are killed.

#include <gmock/gmock.h>
#include <signal.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "tests/lab/lab_support.hpp"
#include "tests/support/scenario_copy.hpp"

namespace system_tests {
namespace {

using testing::HasSubstr;

class LaunchSlow : public LabTest {};

TEST_F(LaunchSlow, TwentyOfTwentyStartsAreReadyAndLeaveNothing) {
  const std::string lab = WriteLab("twenty", OnThree());
  std::vector<double> seconds;
  for (int start = 0; start < 20; ++start) {
    const process::Answer answer = Run(Launch(lab, {"--duration", "0.2", "--out", Folder("twenty").string(), "--record",
                                                    Folder("twenty_recorded").string()}));
    std::smatch match;
    ASSERT_TRUE(std::regex_search(answer.out, match, std::regex("all 5 nodes are ready, ([0-9.]+) s")))
        << "start " << start << ": " << answer.out << answer.err;
    EXPECT_THAT(answer.out, HasSubstr("no process of the run is left on 3 hosts"));
    ExpectNothingIsLeft();
    seconds.push_back(std::stod(match[1]));
  }
  std::sort(seconds.begin(), seconds.end());
  std::printf("ready after %.2f s in the median, %.2f s at most\n", seconds[10], seconds.back());
  RecordProperty("median_ready_s", std::to_string(seconds[10]));
  RecordProperty("max_ready_s", std::to_string(seconds.back()));
  EXPECT_LE(seconds.back(), 5.0);
}

TEST_F(LaunchSlow, FilesBehindLinksAndThoseOfEditorsAreCopiedUnderTheirNames) {
  ScenarioCopy scenario("touch", "lab_links");
  const std::filesystem::path elsewhere = scenario.folder().parent_path();
  std::filesystem::rename(scenario.folder() / "meshes", elsewhere / "shapes");
  std::filesystem::create_directory_symlink("../shapes", scenario.folder() / "meshes");
  std::filesystem::rename(scenario.folder() / "operator.txt", elsewhere / "hand.txt");
  std::filesystem::create_symlink("../hand.txt", scenario.folder() / "operator.txt");
  std::filesystem::create_directory_symlink(".", scenario.folder() / "itself");
  scenario.Write("#scenario.xml#", "what Emacs keeps of a file that is not saved");
  scenario.Write(";notes", "a comment, were it a line of a list");
  std::filesystem::create_symlink("anna@desk.4711:1763740000", scenario.folder() / ".#scenario.xml");  // Emacs' lock

  const process::Answer answer =
      Run(Oos({"launch", scenario.folder().string(), "--lab", WriteLab("links", OnThree()), "--without", "visual_node",
               "--duration", "0.2", "--out", Folder("links").string()}));
  EXPECT_THAT(answer.out, HasSubstr("all 4 nodes are ready")) << answer.err;
  EXPECT_THAT(answer.out, HasSubstr("no process of the run is left on 2 hosts"));
  ExpectNothingIsLeft();
}

TEST_F(LaunchSlow, AHostThatCannotListItsPortsIsRefused) {
  ASSERT_EQ(Run(machines_->On("beta", {"mount", "--bind", "/dev/null", "/usr/bin/ss"})).status, 0);
  const process::Answer answer = Run(Launch(WriteLab("no_ss", OnThree()), {"--without", "visual_node"}));
  EXPECT_EQ(Run(machines_->On("beta", {"umount", "/usr/bin/ss"})).status, 0);
  EXPECT_NE(answer.status, 0);
  EXPECT_THAT(answer.err, HasSubstr("host beta: ss is missing; apt-get install"));
  EXPECT_THAT(answer.err, HasSubstr("nothing was started"));
  ExpectNothingIsLeft();
}

TEST_F(LaunchSlow, TheSameScenarioCompletesOnOneAndOnThreeMachines) {
  std::map<std::string, std::string> on_one = OnThree();
  for (auto& [node, host] : on_one) host = "beta";
  for (const auto& [name, hosts] : {std::pair{"finished_one", on_one}, std::pair{"finished_three", OnThree()}}) {
    SCOPED_TRACE(name);
    const process::Answer answer = Run(Launch(WriteLab(name, hosts), {"--out", Folder(name).string()}), 240.0);
    EXPECT_EQ(answer.status, 0) << answer.out << answer.err;
    EXPECT_THAT(answer.out, HasSubstr("no process of the run is left"));
    ExpectNothingIsLeft();
  }
}

TEST_F(LaunchSlow, AnotherTerminalCanControlTheRunOfAKilledLauncher) {
  const std::string lab = WriteLab("killed", OnThree());
  const auto out = Folder("killed");
  auto launcher = process::PipedChild::Start(Launch(lab, {"--without", "visual_node", "--out", out.string()}));
  ASSERT_TRUE(launcher) << launcher.error().detail;
  ASSERT_TRUE(WaitFor(launcher->get(), "all 4 nodes are ready")) << (*launcher)->out() << (*launcher)->err();
  kill((*launcher)->pid(), SIGKILL);
  WaitForEnd(launcher->get());

  // Supervisor calls a program running once it has lived for a second.
  process::Answer status;
  for (const std::int64_t start = core::MonotonicNow_ns();
       status.out.find("starting") != std::string::npos || status.out.empty();) {
    ASSERT_LT(core::MonotonicNow_ns() - start, 20 * core::kNanosecondsPerSecond) << status.out << status.err;
    status = Run(Oos({"status", "--lab", lab}));
  }
  EXPECT_THAT(status.out, testing::ContainsRegex("physics_node +running"));
  auto attached = process::PipedChild::Start(Oos({"attach", "--lab", lab}));
  ASSERT_TRUE(attached);
  EXPECT_TRUE(WaitFor(attached->get(), "[beta] bus: step press"));
  kill((*attached)->pid(), SIGINT);
  WaitForEnd(attached->get());
  EXPECT_THAT((*attached)->out(), HasSubstr("the run goes on"));

  const process::Answer stop = Run(Oos({"stop", "--lab", lab}));
  EXPECT_EQ(stop.status, 0) << stop.out << stop.err;
  EXPECT_TRUE(std::filesystem::exists(out / "physics_node.log"));
  ExpectNothingIsLeft();
}

TEST_F(LaunchSlow, ASweepIsRunOnTwoHostsAndCollected) {
  const auto out = Folder("sweep");
  const process::Answer answer =
      Run(machines_->AtLauncher(
              {"env", "PARALLEL_SSH=ssh -F " + (machines_->folder() / "ssh_config").string(),
               std::string("OOS=") + VR_OOS_BINARY_DIR + "/bin/oos", std::string(VR_OOS_BINARY_DIR) + "/bin/oos",
               "sweep", std::string(VR_OOS_SOURCE_DIR) + "/scenarios/free_collision", "--grid", "run.method=paper,fast",
               "--seeds", "3", "--hosts", "10.77.0.11,10.77.0.12", "--out", out.string()}),
          300.0);
  EXPECT_EQ(answer.status, 0) << answer.out << answer.err;
  std::ifstream jobs(out / "jobs.log");
  const std::string log{std::istreambuf_iterator<char>(jobs), {}};
  EXPECT_THAT(log, HasSubstr("10.77.0.11"));
  EXPECT_THAT(log, HasSubstr("10.77.0.12"));
  std::ifstream results(out / "results.csv");
  int num_rows = -1;  // the first line names the columns
  for (std::string line; std::getline(results, line);) num_rows += line.empty() ? 0 : 1;
  EXPECT_EQ(num_rows, 6);
  std::printf("%s", answer.out.c_str());
  ExpectNothingIsLeft();
}

double MeanOf(const nlohmann::json& report, const std::string& chain) {
  return report.contains(chain) ? report[chain].value("mean", -1.0) : -1.0;
}

// Device bridge and haptic rendering on one machine, physics on another, the viewer on a third.
TEST_F(LaunchSlow, LatenciesOnThreeMachinesAreAtMostThePapersAndAddUp) {
  const auto out = Folder("latency");
  const process::Answer run = Run(Launch(WriteLab("latency", OnThree()), {"--out", out.string()}), 240.0);
  EXPECT_EQ(run.status, 0) << run.out << run.err;
  const process::Answer latency = Run(Oos({"latency", out.string()}));
  std::printf("%s%s", latency.out.c_str(), latency.err.c_str());
  EXPECT_EQ(latency.status, 0) << "hops and the bridge's own log are more than 5 % apart";
  EXPECT_THAT(latency.out, HasSubstr("several machines"));
  EXPECT_EQ(latency.out.find("were not compared"), std::string::npos);
  std::ifstream in(out / "report.json");
  const nlohmann::json report = nlohmann::json::parse(in, nullptr, false);
  ASSERT_TRUE(report.is_object());
  const double t1_ms = MeanOf(report, "t1_ms"), t2_ms = MeanOf(report, "t2_state_ms");
  EXPECT_GT(t1_ms, 0.0);
  EXPECT_LE(t1_ms, 2.8);
  EXPECT_GT(t2_ms, 0.0);
  EXPECT_LE(t2_ms, 7.1);
  const double bound_ms = report["t2_state_ms"].value("clock_bound", -1.0);
  EXPECT_GT(bound_ms, 0.0);
  std::printf("t1 %.2f ms, t2_state %.2f ms +- %.2f ms by the clocks\n", t1_ms, t2_ms, bound_ms);
}

}  // namespace
}  // namespace system_tests
