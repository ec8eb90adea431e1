#include "tools/oos/run/session/session.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "scene/load_scenario.hpp"

namespace oos {
namespace {

// Shell scripts in place of the nodes. None becomes ready, so that the session stops them at once.
class SessionOfScripts : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    setenv("DISPLAY", ":0", 1);  // which nobody opens
    for (const char* node : kNodeNames) Script(node, "exit 0");
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // A node that runs `at_sigterm` when it is told to end.
  void Script(const std::string& node, const std::string& at_sigterm) {
    const std::filesystem::path file = folder_ / node;
    std::ofstream(file) << "#!/bin/sh\ntrap '" << at_sigterm << "' TERM\necho $$ > " << (folder_ / node).string()
                        << ".pid\nwhile :; do sleep 0.02; done\n";
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  }

  SessionOutcome Run() {
    const auto scenario = scene::LoadScenario(std::filesystem::path(VR_OOS_SOURCE_DIR) / "scenarios/touch");
    SessionOptions options;
    options.out = folder_ / "out";
    options.program_folder = folder_;
    options.start_patience_s = 0.5;
    const auto outcome = RunSession(*scenario, options);
    EXPECT_TRUE(outcome) << outcome.error().detail;
    return outcome.value_or(SessionOutcome{});
  }

  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / ("session_of_scripts_" + std::to_string(getpid()));
};

// The viewer's last pictures take longer than a node that hangs is waited for.
TEST_F(SessionOfScripts, AViewerMayFinishItsPicturesAfterTheNodesHaveBeenKilled) {
  Script("haptic_node", "");
  const std::string haptic_node = "$(cat " + (folder_ / "haptic_node.pid").string() + ")";
  const std::filesystem::path picture = folder_ / "picture";
  Script("visual_node",
         "while kill -0 " + haptic_node + "; do sleep 0.02; done; echo > " + picture.string() + "; exit 0");
  EXPECT_EQ(Run().killed, std::vector<std::string>{"haptic_node"});
  EXPECT_TRUE(std::filesystem::exists(picture));
}

}  // namespace
}  // namespace oos
