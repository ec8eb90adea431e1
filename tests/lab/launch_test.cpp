// Launches on three machines made of namespaces: other addresses, other clocks, nothing shared but the disk.

#include <gmock/gmock.h>
#include <signal.h>

#include <nlohmann/json.hpp>

#include "tests/lab/lab_support.hpp"
#include "tests/support/scenario_copy.hpp"

namespace system_tests {
namespace {

using testing::HasSubstr;

class LaunchTest : public LabTest {};

// Signals the launcher. nsenter replaces itself by the launcher, so they are one process.
void Signal(const process::PipedChild& child, int number) {
  kill(child.pid(), number);
}

int Count(const std::string& text, const std::string& part) {
  int count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST_F(LaunchTest, RunsOnThreeMachinesRecordsAndLeavesNothing) {
  const auto out = Folder("three");
  const process::Answer answer = Run(
      Launch(WriteLab("three", OnThree()), {"--duration", "2", "--method", "fast", "--out", out.string(), "--record",
                                            (out / "rec").string(), "--steps", (out / "steps").string()}));
  EXPECT_THAT(answer.out, HasSubstr("all 5 nodes are ready"));
  EXPECT_THAT(answer.out, HasSubstr("[alpha] haptic_node: ready"));
  EXPECT_THAT(answer.out, HasSubstr("[beta] bus: logic_node: step_entered press"));
  EXPECT_THAT(answer.out, HasSubstr("no process of the run is left on 3 hosts"));
  EXPECT_THAT(answer.out, HasSubstr("limit of 2 s reached in step "));
  EXPECT_EQ(answer.status, 1) << answer.err;  // the procedure was cut short
  for (const char* file : {"steps/haptic_node.mcap", "steps/physics_node.mcap", "steps/logic_node.mcap",
                           "device_bridge.json", "haptic_node.json", "physics_node.log", "visual_node.log",
                           "clocks.csv", "supervisord-gamma.log", "report.md", "rec/run.mcap"}) {
    EXPECT_TRUE(std::filesystem::exists(out / file)) << file;
  }
  ExpectNothingIsLeft();
  std::ifstream in(out / "report.json");
  const nlohmann::json report = nlohmann::json::parse(in, nullptr, false);
  ASSERT_TRUE(report.is_object());
  EXPECT_EQ(report["method"], "fast");  // what ran, not what the scenario's file says
  for (const char* node : {"logic_node", "physics_node", "haptic_node"}) {
    const process::Answer replay =
        Run({std::string(VR_OOS_BINARY_DIR) + "/bin/oos", "replay",
             (out / "steps" / (node + std::string(".mcap"))).string(), "--check", "--scenario",
             std::string(VR_OOS_SOURCE_DIR) + "/scenarios/touch/scenario.xml"});
    EXPECT_EQ(replay.status, 0) << replay.out << replay.err;
  }
}

TEST_F(LaunchTest, ASecondLauncherIsRefusedByNameAndAnyTerminalCanStop) {
  const std::string lab = WriteLab("two_launchers", OnThree());
  auto first =
      process::PipedChild::Start(Launch(lab, {"--without", "visual_node", "--out", Folder("two_launchers").string()}));
  ASSERT_TRUE(first) << first.error().detail;
  ASSERT_TRUE(WaitFor(first->get(), "all 4 nodes are ready")) << (*first)->out() << (*first)->err();

  const process::Answer second = Run(Launch(lab, {"--without", "visual_node"}));
  EXPECT_EQ(second.status, 1);
  EXPECT_THAT(second.err, HasSubstr("host alpha is in use"));
  EXPECT_THAT(second.err, HasSubstr("(process " + std::to_string((*first)->pid()) + ")"));
  EXPECT_THAT(second.err, HasSubstr("nothing was started"));

  const process::Answer status = Run(Oos({"status", "--lab", lab}));
  EXPECT_EQ(status.status, 0);
  // A node may be ready before supervisord, which watches it for its first second, calls it running.
  EXPECT_THAT(status.out, testing::ContainsRegex("physics_node +(running|starting)"));

  const process::Answer stop = Run(Oos({"stop", "--lab", lab}));
  EXPECT_EQ(stop.status, 0) << stop.err;
  WaitForEnd(first->get());
  EXPECT_THAT((*first)->out(), HasSubstr("no process of the run is left on 2 hosts"));
  ExpectNothingIsLeft();
  EXPECT_THAT(Run(Oos({"status", "--lab", lab})).out, HasSubstr("beta: free"));
}

TEST_F(LaunchTest, CtrlCLeavesNothing) {
  const auto out = Folder("ctrl_c");
  auto launcher = process::PipedChild::Start(
      Launch(WriteLab("ctrl_c", OnThree()), {"--out", out.string(), "--record", (out / "rec").string()}));
  ASSERT_TRUE(launcher) << launcher.error().detail;
  ASSERT_TRUE(WaitFor(launcher->get(), "physics_node: ready")) << (*launcher)->out() << (*launcher)->err();
  Signal(**launcher, SIGINT);
  WaitForEnd(launcher->get());
  EXPECT_THAT((*launcher)->out(), HasSubstr("ends: interrupted"));
  EXPECT_THAT((*launcher)->out(), HasSubstr("no process of the run is left on 3 hosts"));
  ExpectNothingIsLeft();
}

TEST_F(LaunchTest, AMissingAssetIsNamedAndNothingIsStarted) {
  const ScenarioCopy scenario("touch", "lab_asset");
  std::filesystem::remove(scenario.folder() / "meshes/ball.obj");
  const process::Answer answer =
      Run(Oos({"launch", scenario.folder().string(), "--lab", WriteLab("missing_asset", OnThree())}));
  EXPECT_NE(answer.status, 0);
  EXPECT_THAT(answer.err, HasSubstr("meshes/ball.obj"));
  EXPECT_THAT(answer.err, HasSubstr("nothing was started"));
  EXPECT_EQ(Count(answer.err, "\n"), 2) << answer.err;
  ExpectNothingIsLeft();
}

struct BadLab {
  const char* name;
  const char* from;
  const char* to;
  const char* message;
  friend void PrintTo(const BadLab& bad, std::ostream* out) { *out << bad.name; }
};

class LaunchRefuses : public LabTest, public testing::WithParamInterface<BadLab> {};

TEST_P(LaunchRefuses, WithOneMessageAndNothingStarted) {
  const BadLab& bad = GetParam();
  const std::string file = WriteLab(bad.name, OnThree());
  std::string text;
  {
    std::ifstream in(file);
    text.assign(std::istreambuf_iterator<char>(in), {});
  }
  const std::size_t at = text.find(bad.from);
  ASSERT_NE(at, std::string::npos);
  std::ofstream(file) << text.replace(at, std::string(bad.from).size(), bad.to);
  // Needed by some of the cases: a key that the machines do not accept; a port in use.
  std::ofstream(machines_->folder() / "wrong_config")
      << "UserKnownHostsFile " << (machines_->folder() / "known_hosts").string()
      << "\nIdentitiesOnly yes\nIdentityFile /no_such_key\n";
  const auto listener = process::PipedChild::Start(
      machines_->InNetworkOf("beta", {std::string(VR_OOS_BINARY_DIR) + "/bin/oos", "registry", "--registry",
                                      "tcp://10.77.0.12:7999", "--session", "1", "--no_encryption"}));
  ASSERT_TRUE(listener);
  ASSERT_TRUE(WaitFor(listener->get(), "\"up\"")) << (*listener)->err();

  const process::Answer answer = Run(Launch(file, {"--without", "visual_node", "--out", Folder("refused").string()}));
  EXPECT_NE(answer.status, 0);
  EXPECT_THAT(answer.err, HasSubstr(bad.message));
  EXPECT_THAT(answer.err, HasSubstr("nothing was started"));
  // One message for each host that is concerned, and the last line.
  EXPECT_EQ(Count(answer.err, bad.message), Count(answer.err, "\n") - 1) << answer.err;
  kill((*listener)->pid(), SIGTERM);
  WaitForEnd(listener->get());
  ExpectNothingIsLeft();
}

INSTANTIATE_TEST_SUITE_P(
    , LaunchRefuses,
    testing::Values(
        BadLab{"UnknownHost", "name=\"logic_node\" host=\"beta\"", "name=\"logic_node\" host=\"delta\"",
               "unknown host 'delta'"},
        BadLab{"NodeNowhere", "<node name=\"logic_node\" host=\"beta\"/>", "", "logic_node is not placed on a host"},
        BadLab{"NobodyListens", "name=\"beta\" address", "name=\"beta\" port=\"2222\" address",
               "host beta (10.77.0.12) does not let us in"},
        BadLab{"WrongKey", "/ssh_config", "/wrong_config", "does not let us in: root@10.77.0.11: Permission denied"},
        BadLab{"PortInUse", "<registry host=\"beta\"/>", "<registry host=\"beta\" port=\"7999\"/>",
               "port 7999 is in use (10.77.0.12:7999)"},
        BadLab{"OtherPrograms", "name=\"alpha\"", "name=\"alpha\" programs=\"/usr/bin\"", "is of another version"},
        BadLab{"DiskFull", "name=\"DiskFull\"", "name=\"DiskFull\" min_free_MB=\"1e9\"", "min_free_MB requires"},
        BadLab{"NoSuchInterface", "name=\"alpha\"", "name=\"alpha\" bind=\"eth7\"", "it has no 'eth7'"},
        BadLab{"NoSuchCores", "name=\"haptic_node\"", "name=\"haptic_node\" cores=\"900\"", "it has no cores 900"},
        BadLab{"NoSuchDevice", "name=\"device_bridge\" host=\"alpha\"/>",
               "name=\"device_bridge\" host=\"alpha\"><device role=\"right\" path=\"/dev/no_arm\"/></node>",
               "device /dev/no_arm is not there"}),
    [](const auto& one) { return one.param.name; });

}  // namespace
}  // namespace system_tests
