// A tracked forearm collides as a body of the scene: its bracelet feels what it pushes, and the hand does not.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support.hpp"
#include "tools/oos/run/session/session.hpp"

namespace system_tests {
namespace {

TEST(Forearm, PushesABlockThatItsBraceletFeelsAndTheHandDoesNot) {
  oos::SessionOptions options;
  options.out = std::filesystem::path(VR_OOS_BINARY_DIR) / "forearm";
  std::filesystem::remove_all(options.out);
  std::filesystem::create_directories(options.out);
  options.without = {"visual_node"};
  options.program_folder = std::filesystem::path(VR_OOS_BINARY_DIR) / "bin";
  const auto outcome = oos::RunSession(Load("touch/forearm.xml"), options);
  ASSERT_TRUE(outcome) << outcome.error().detail;
  EXPECT_TRUE(outcome->is_final) << outcome->why << ": the block is not at the bumper";

  std::ifstream in(options.out / "device_bridge.json");
  const nlohmann::json report = nlohmann::json::parse(in, nullptr, false);
  ASSERT_TRUE(report.is_object());
  EXPECT_GT(report["tactile"][0]["greatest_level"].get<double>(), 0.0);
  EXPECT_EQ(report["roles"][0]["role"], "right");
  EXPECT_EQ(report["roles"][0]["peak_force_N"].get<double>(), 0.0);
  EXPECT_EQ(report["roles"][1]["peak_force_N"].get<double>(), 0.0) << "it has no motor";
}

}  // namespace
}  // namespace system_tests
