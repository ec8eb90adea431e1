// What takes minutes: many starts, the whole procedure, launchers and nodes that die.

#include <gmock/gmock.h>
#include <signal.h>

#include <regex>

#include "tests/lab/lab_support.hpp"

namespace system_tests {
namespace {

using testing::HasSubstr;

class LaunchSlow : public LabTest {};

TEST_F(LaunchSlow, TwentyOfTwentyStartsAreReadyAndLeaveNothing) {
  const std::string lab = WriteLab("twenty", OnThree());
  std::vector<double> seconds;
  for (int start = 0; start < 20; ++start) {
    const oos::Answer answer = Run(Launch(lab, {"--duration", "0.2", "--out", Folder("twenty").string(), "--record",
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
}

TEST_F(LaunchSlow, TheSameScenarioIsFinishedOnOneAndOnThreeMachines) {
  std::map<std::string, std::string> on_one = OnThree();
  for (auto& [node, host] : on_one) host = "beta";
  for (const auto& [name, hosts] : {std::pair{"finished_one", on_one}, std::pair{"finished_three", OnThree()}}) {
    SCOPED_TRACE(name);
    const oos::Answer answer = Run(Launch(WriteLab(name, hosts), {"--out", Folder(name).string()}), 240.0);
    EXPECT_EQ(answer.status, 0) << answer.out << answer.err;
    EXPECT_THAT(answer.out, HasSubstr("no process of the run is left"));
    ExpectNothingIsLeft();
  }
}

TEST_F(LaunchSlow, ALauncherThatIsKilledLeavesTheRunToAnotherTerminal) {
  const std::string lab = WriteLab("killed", OnThree());
  const auto out = Folder("killed");
  auto launcher = oos::PipedChild::Start(Launch(lab, {"--without", "visual_node", "--out", out.string()}));
  ASSERT_TRUE(launcher) << launcher.error().detail;
  ASSERT_TRUE(WaitFor(launcher->get(), "all 4 nodes are ready")) << (*launcher)->out() << (*launcher)->err();
  kill((*launcher)->pid(), SIGKILL);
  WaitForEnd(launcher->get());

  const oos::Answer status = Run(Oos({"status", "--lab", lab}));
  EXPECT_THAT(status.out, testing::ContainsRegex("physics_node +running"));
  auto attached = oos::PipedChild::Start(Oos({"attach", "--lab", lab}));
  ASSERT_TRUE(attached);
  EXPECT_TRUE(WaitFor(attached->get(), "[beta] bus: step press"));
  kill((*attached)->pid(), SIGINT);
  WaitForEnd(attached->get());
  EXPECT_THAT((*attached)->out(), HasSubstr("the run goes on"));

  const oos::Answer stop = Run(Oos({"stop", "--lab", lab}));
  EXPECT_EQ(stop.status, 0) << stop.out << stop.err;
  EXPECT_TRUE(std::filesystem::exists(out / "physics_node.log"));
  ExpectNothingIsLeft();
}

}  // namespace
}  // namespace system_tests
