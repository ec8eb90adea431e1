// The nodes may start in any order. Tests all 120 orders; each node starts when the one before has registered.

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/lab/lab_support.hpp"
#include "tools/oos/run/session/virtual_display.hpp"
#include "tools/process/group.hpp"
#include "tools/process/piped_child.hpp"

namespace system_tests {
namespace {

constexpr double kPatience_s = 60.0;
const std::string kBin = std::string(VR_OOS_BINARY_DIR) + "/bin/";

class StartOrders : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_);
    auto display = oos::StartVirtualDisplay(&display_group_, folder_ / "Xvfb.log");
    ASSERT_TRUE(display) << display.error().detail;
    display_ = *display;
  }

  static std::vector<std::string> Words(const std::string& program, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), kBin + program);
    arguments.insert(arguments.end(), {"--registry", "tcp://127.0.0.1:7451", "--session", "7", "--no_encryption"});
    return arguments;
  }
  void Spawn(process::Group* group, const std::string& name) {
    process::Command command;
    command.name = name;
    std::vector<std::string> words = Words(
        name,
        {"--scenario", std::string(VR_OOS_SOURCE_DIR) + "/scenarios/touch/scenario.xml", "--out", folder_.string()});
    if (name == "visual_node") words.emplace_back("--headless");
    command.program = words[0];
    command.arguments.assign(words.begin() + 1, words.end());
    command.environment["DISPLAY"] = display_;
    command.log = folder_ / (name + ".log");
    ASSERT_TRUE(group->Spawn(command));
  }

  std::filesystem::path folder_ = std::filesystem::path(VR_OOS_BINARY_DIR) / "lab" / "orders";
  process::Group display_group_;
  std::string display_;
};

TEST_F(StartOrders, All120ReachReady) {
  std::vector<std::string> names = {"device_bridge", "haptic_node", "logic_node", "physics_node", "visual_node"};
  int order = 0;
  do {
    SCOPED_TRACE(testing::Message() << ++order << ": " << testing::PrintToString(names));
    const auto registry = process::PipedChild::Start(Words("oos", {"registry"}));
    ASSERT_TRUE(registry);
    ASSERT_TRUE(WaitFor(registry->get(), "\"is\":\"up\"", kPatience_s)) << (*registry)->err();
    process::Group group;
    for (const std::string& name : names) {
      Spawn(&group, name);
      ASSERT_TRUE(WaitFor(registry->get(), "\"is\":\"registered\",\"node\":\"" + name + "\"", kPatience_s)) << name;
    }
    for (const std::string& name : names) {
      EXPECT_TRUE(WaitFor(registry->get(), R"("is":"ready","name":"ready","node":")" + name + "\"", kPatience_s))
          << name;
    }
    group.StopAll(5.0);
  } while (std::next_permutation(names.begin(), names.end()));
  EXPECT_EQ(order, 120);
}

}  // namespace
}  // namespace system_tests
