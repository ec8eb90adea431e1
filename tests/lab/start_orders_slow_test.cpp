// The nodes may come in any order: all 120, each node started when the one before has reached the registry.

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "core/clock.hpp"
#include "tools/oos/process.hpp"
#include "tools/oos/virtual_display.hpp"

namespace system_tests {
namespace {

constexpr std::int64_t kPatience_ns = 60 * core::kNanosecondsPerSecond;
const std::string kBin = std::string(VR_OOS_BINARY_DIR) + "/bin/";

std::string Read(const std::filesystem::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

class StartOrders : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_);
    auto display = oos::StartVirtualDisplay(&display_group_, folder_ / "Xvfb.log");
    ASSERT_TRUE(display) << display.error().detail;
    display_ = *display;
  }

  void Spawn(oos::ProcessGroup* group, const std::string& name, std::vector<std::string> arguments) {
    oos::Command command;
    command.name = name;
    command.program = kBin + (name == "registry" ? "oos" : name);
    command.arguments = std::move(arguments);
    command.arguments.insert(command.arguments.end(),
                             {"--registry", "tcp://127.0.0.1:7451", "--session", "7", "--no_encryption"});
    command.environment["DISPLAY"] = display_;
    command.log = folder_ / (name + ".log");
    ASSERT_TRUE(group->Spawn(command));
  }

  // Until the registry's log holds `text`.
  [[nodiscard]] bool Told(const std::string& text) const {
    const std::int64_t deadline_ns = core::MonotonicNow_ns() + kPatience_ns;
    while (Read(folder_ / "registry.log").find(text) == std::string::npos) {
      if (core::MonotonicNow_ns() > deadline_ns) return false;
      const timespec pause{0, 5'000'000};
      nanosleep(&pause, nullptr);
    }
    return true;
  }

  std::filesystem::path folder_ = std::filesystem::path(VR_OOS_BINARY_DIR) / "lab" / "orders";
  oos::ProcessGroup display_group_;
  std::string display_;
};

TEST_F(StartOrders, All120ReachReady) {
  std::vector<std::string> names = {"device_bridge", "haptic_node", "logic_node", "physics_node", "visual_node"};
  int order = 0;
  do {
    SCOPED_TRACE(testing::Message() << ++order << ": " << testing::PrintToString(names));
    std::filesystem::remove(folder_ / "registry.log");
    oos::ProcessGroup group;
    Spawn(&group, "registry", {"registry"});
    ASSERT_TRUE(Told("\"is\":\"up\""));
    for (const std::string& name : names) {
      std::vector<std::string> arguments = {
          "--scenario", std::string(VR_OOS_SOURCE_DIR) + "/scenarios/touch/scenario.xml", "--out", folder_.string()};
      if (name == "visual_node") arguments.push_back("--headless");
      Spawn(&group, name, arguments);
      ASSERT_TRUE(Told("\"is\":\"registered\",\"node\":\"" + name + "\"")) << name;
    }
    for (const std::string& name : names) {
      EXPECT_TRUE(Told("\"is\":\"ready\",\"name\":\"ready\",\"node\":\"" + name + "\"")) << name;
    }
    group.StopAll(5.0);
  } while (std::next_permutation(names.begin(), names.end()));
  EXPECT_EQ(order, 120);
}

}  // namespace
}  // namespace system_tests
