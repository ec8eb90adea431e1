#include "nodes/visual_node/force_loop.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <string>

namespace visual_node {
namespace {

TEST(ForceLoop, IsThereWhileANodeOfItRunsOnThisMachine) {
  const auto processes = std::filesystem::path(testing::TempDir()) / ("processes_" + std::to_string(getpid()));
  const auto start = [&](const std::string& id, const std::string& name) {
    std::filesystem::create_directories(processes / id);
    std::ofstream(processes / id / "comm") << "its-thread\n";
    std::ofstream(processes / id / "cmdline") << "/usr/lib/vr-oos/" << name << '\0' << "--rt" << '\0' << "try" << '\0';
  };
  start("1", "systemd");
  start("20", "visual_node");
  start("21", "logic_node");
  std::filesystem::create_directories(processes / "sys");
  EXPECT_FALSE(HasForceLoop(processes));
  for (const char* name : {"haptic_node", "physics_node", "device_bridge", "haptic_physics_node"}) {
    start("300", name);
    EXPECT_TRUE(HasForceLoop(processes)) << name;
    std::filesystem::remove_all(processes / "300");
    EXPECT_FALSE(HasForceLoop(processes));
  }
  std::filesystem::remove_all(processes);
  EXPECT_FALSE(HasForceLoop(processes)) << "no list";
}

}  // namespace
}  // namespace visual_node
