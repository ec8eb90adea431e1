// All that an operator can wear, at once and beside HUG: each of them does its part of the same run, which is recorded
// and replayed.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "bus/log/mcap_reader.hpp"
#include "nodes/lockstep/replay_steps.hpp"
#include "tests/support.hpp"
#include "tools/oos/run/session/session.hpp"

namespace system_tests {
namespace {

std::filesystem::path AllWornFolder() {
  return std::filesystem::path(VR_OOS_BINARY_DIR) / "all_worn";
}

oos::SessionOptions AllWornOptions() {
  oos::SessionOptions options;
  options.out = AllWornFolder();
  std::filesystem::remove_all(options.out);
  std::filesystem::create_directories(options.out / "steps");
  options.steps = options.out / "steps";
  options.is_recorded = true;
  options.without = {"visual_node"};
  options.program_folder = std::filesystem::path(VR_OOS_BINARY_DIR) / "bin";
  options.duration_s = 80.0;
  return options;
}

// How many messages of each topic the bridge recorded.
std::map<std::string, int> RecordedByTheBridge() {
  std::map<std::string, int> counts;
  const auto read =
      bus::log::ReadMcap(oos::RecordingFolder(AllWornFolder()) / "device_bridge.mcap",
                         [&](const bus::log::Channel& channel, const bus::log::Message&) { ++counts[channel.topic]; });
  EXPECT_TRUE(read) << (read ? "" : read.error().detail);
  return counts;
}

TEST(AllWorn, TakePartInTheSameRunAndItsRecording) {
  const scene::Scenario scenario = Load("two_hands/everything.xml");
  const auto outcome = oos::RunSession(scenario, AllWornOptions());
  ASSERT_TRUE(outcome) << outcome.error().detail;
  EXPECT_TRUE(outcome->is_final) << outcome->why;

  std::ifstream in(AllWornFolder() / "device_bridge.json");
  const nlohmann::json report = nlohmann::json::parse(in, nullptr, false);
  ASSERT_TRUE(report.is_object());
  ASSERT_EQ(report["tactile"].size(), 3U);
  for (const nlohmann::json& worn : report["tactile"]) {
    EXPECT_GT(worn["frames"].get<int>(), 0) << worn;
    // Electrodes begin anew after a stall, and their first pulses are too weak to be given.
    const int allowed = worn["device"] == "fingertip" ? worn["frames"].get<int>() / 100 : 0;
    EXPECT_LE(worn["errors"].get<int>(), allowed) << worn;
  }
  // The module and the plug touch each other.
  for (const std::size_t bracelet : {0, 1}) {
    EXPECT_GT(report["tactile"][bracelet]["greatest_level"].get<double>(), 0.0) << bracelet;
  }
  EXPECT_TRUE(report["roles"][0]["muscle"].is_null());
  EXPECT_EQ(report["roles"][1]["muscle"]["faults"], 0);
  EXPECT_EQ(report["samples_over_cap"], 0);

  std::map<std::string, int> recorded = RecordedByTheBridge();
  for (const char* topic : {"tactile/bracelet_left/state", "tactile/bracelet_right/state", "tactile/fingertip/state",
                            "user/operator/head", "device/left/state", "device/right/state"}) {
    EXPECT_GT(recorded[topic], 10) << topic;
  }

  for (const std::string node : {"physics_node", "haptic_node"}) {
    const std::filesystem::path file = AllWornFolder() / "steps" / (node + ".mcap");
    const auto recorded_nodes = lockstep::ReadRecordedNodes(file);
    ASSERT_TRUE(recorded_nodes) << recorded_nodes.error().detail;
    const auto replayed = lockstep::ReplaySteps(file, recorded_nodes->front(), scenario, {});
    if (!replayed && replayed.error().detail.find("time ran short") != std::string::npos) continue;  // a busy machine
    ASSERT_TRUE(replayed) << replayed.error().detail;
    EXPECT_EQ(replayed->num_inexact, 0U) << lockstep::Describe(recorded_nodes->front(), *replayed);
  }
}

}  // namespace
}  // namespace system_tests
