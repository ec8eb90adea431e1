// A launched run observed and stopped from another machine, with a host that does not answer, and without a display.

#include <gmock/gmock.h>
#include <signal.h>

#include "tests/lab/lab_support.hpp"

namespace system_tests {
namespace {

using testing::HasSubstr;

class ElsewhereTest : public LabTest {
 protected:
  static std::string Replaced(const std::string& file, const std::string& from, const std::string& to) {
    std::string text;
    {
      std::ifstream in(file);
      text.assign(std::istreambuf_iterator<char>(in), {});
    }
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    std::ofstream(file) << text.replace(at, from.size(), to);
    return file;
  }
  static std::unique_ptr<process::PipedChild> StartWithoutPictures(const std::string& lab, const std::string& name) {
    auto launcher =
        process::PipedChild::Start(Launch(lab, {"--without", "visual_node", "--out", Folder(name).string()}));
    EXPECT_TRUE(launcher) << launcher.error().detail;
    if (!launcher) return nullptr;
    EXPECT_TRUE(WaitFor(launcher->get(), "all 4 nodes are ready")) << (*launcher)->out() << (*launcher)->err();
    return std::move(*launcher);
  }
  // The command on gamma, a machine without any part of the run.
  static std::vector<std::string> OosOnGamma(std::vector<std::string> words) {
    words.insert(words.begin(), std::string(VR_OOS_BINARY_DIR) + "/bin/oos");
    return machines_->On("gamma", words);
  }
};

TEST_F(ElsewhereTest, AnotherMachineViewsAndStopsTheRunWhileItsLauncherLives) {
  const std::string lab = WriteLab("elsewhere", OnThree());
  // Gamma is not used by the run: nothing in its home belongs to the run.
  const auto precious = machines_->folder() / "gamma/home/keys/precious";
  std::filesystem::create_directories(precious.parent_path());
  std::ofstream(precious) << "mine\n";
  const auto launcher = StartWithoutPictures(lab, "elsewhere");
  ASSERT_TRUE(launcher);

  const process::Answer view = Run(OosOnGamma(
      {"view", std::string(VR_OOS_SOURCE_DIR) + "/scenarios/touch", "--text", "--seconds", "3", "--lab", lab}));
  EXPECT_EQ(view.status, 0) << view.err;
  EXPECT_THAT(view.out, HasSubstr("  block "));

  const auto out = Folder("elsewhere_collected");
  const process::Answer stop = Run(OosOnGamma({"stop", "--lab", lab, "--out", out.string()}));
  EXPECT_EQ(stop.status, 0) << stop.out << stop.err;
  EXPECT_THAT(stop.out, HasSubstr("stopped; what it left is in " + out.string()));
  EXPECT_TRUE(std::filesystem::exists(out / "physics_node.log"));
  WaitForEnd(launcher.get());
  EXPECT_EQ(launcher->status(), 1);
  EXPECT_THAT(launcher->out(), HasSubstr("ends: stopped from elsewhere by "));
  EXPECT_TRUE(std::filesystem::exists(precious));
  ExpectNothingIsLeft();
  const process::Answer status = Run(Oos({"status", "--lab", lab}));
  for (const char* free : {"alpha: free", "beta: free", "gamma: free"}) EXPECT_THAT(status.out, HasSubstr(free));
}

TEST_F(ElsewhereTest, AHostThatDoesNotAnswerHindersNoOther) {
  const std::string lab = Replaced(WriteLab("silent", OnThree()), "  <registry",
                                   "  <host name=\"delta\" address=\"10.77.0.99\"/>\n  <registry");
  const auto launcher = StartWithoutPictures(lab, "silent");
  ASSERT_TRUE(launcher);
  kill(launcher->pid(), SIGKILL);
  WaitForEnd(launcher.get());
  const process::Answer status = Run(Oos({"status", "--lab", lab}));
  EXPECT_EQ(status.status, 1);
  EXPECT_THAT(status.out, testing::ContainsRegex("physics_node +(running|starting)"));
  EXPECT_THAT(status.out, HasSubstr("host delta (10.77.0.99) does not let us in"));
  const process::Answer stop = Run(Oos({"stop", "--lab", lab}));
  EXPECT_EQ(stop.status, 1);
  EXPECT_THAT(stop.out, HasSubstr("host delta (10.77.0.99) does not let us in"));
  EXPECT_THAT(stop.out, HasSubstr("stopped; what it left is in "));
  ExpectNothingIsLeft();
}

TEST_F(ElsewhereTest, AViewerThatCannotStartEndsNothing) {
  const std::string lab = Replaced(WriteLab("no_display", OnThree()), "<node name=\"visual_node\"",
                                   "<node name=\"visual_node\" display=\":977\"");
  const process::Answer answer = Run(Launch(lab, {"--out", Folder("no_display").string()}), 200.0);
  EXPECT_EQ(answer.status, 0) << answer.out << answer.err;
  EXPECT_THAT(answer.out, HasSubstr("exited: visual_node"));
  EXPECT_THAT(answer.out, HasSubstr("no process of the run is left on 3 hosts"));
  ExpectNothingIsLeft();
}

}  // namespace
}  // namespace system_tests
