// A device in another process takes part in a run: the example of docs/howto/own-device.md, in Python.

#include <gtest/gtest.h>
#include <signal.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "bus/log/mcap_reader.hpp"
#include "bus/topics.hpp"
#include "device/calibration.hpp"
#include "tests/support.hpp"
#include "tools/oos/run/session.hpp"
#include "tools/process/group.hpp"
#include "tools/process/piped_child.hpp"

namespace system_tests {
namespace {

constexpr const char* kPython = "/usr/bin/python3";

process::Command PythonDevice(const std::filesystem::path& log, int port) {
  process::Command command;
  command.name = "python_device";
  command.program = kPython;
  command.arguments = {VR_OOS_SOURCE_DIR "/clients/python/example_device.py", std::to_string(port)};
  command.log = log;
  return command;
}

nlohmann::json ReadReport(const std::filesystem::path& file) {
  std::ifstream in(file);
  return nlohmann::json::parse(in, nullptr, false);
}

bool HasEvent(const oos::SessionOutcome& outcome, const std::string& name, const std::string& detail) {
  for (const core::Event& event : outcome.events) {
    if (event.name == name && event.detail.find(detail) != std::string::npos) return true;
  }
  return false;
}

oos::SessionOptions Options(const std::string& name, int port) {
  oos::SessionOptions options;
  options.out = std::filesystem::path(VR_OOS_BINARY_DIR) / "devices" / name;
  std::filesystem::remove_all(options.out);
  std::filesystem::create_directories(options.out);
  options.without = {"visual_node"};
  options.program_folder = std::filesystem::path(VR_OOS_BINARY_DIR) / "bin";
  options.devices = {"right=udp:" + std::to_string(port)};
  options.duration_s = 90.0;
  return options;
}

// The device is unplugged (its process killed) while it presses, and plugged in again (started anew) half a second
// later. It is calibrated, so it then is where it says, and begins its path anew.
TEST(Devices, APythonDeviceCarriesOutTouchAlthoughItIsUnpluggedMeanwhile) {
  constexpr int kPort = 27460;
  constexpr double kPressing_N = 3.0;
  oos::SessionOptions options = Options("unplugged", kPort);
  device::Calibration calibration;
  calibration.name = "example in Python";
  calibration.serial = "1";
  calibration.X_WB.translation = Load("touch").devices[0].X_WD_start.translation;
  ASSERT_TRUE(device::Keep(calibration, options.out / "calibrations"));
  ASSERT_EQ(setenv("VR_OOS_DEVICES", (options.out / "calibrations").c_str(), 1), 0);
  process::Group devices;
  ASSERT_TRUE(devices.Spawn(PythonDevice(options.out / "device_1.log", kPort)));
  double unplugged_s = 0.0, replugged_s = 0.0;
  options.while_running = [&](process::Group&, double seconds, double force_N) {
    if (unplugged_s == 0.0 && force_N > kPressing_N) {
      unplugged_s = seconds;
      kill(devices.children().front().pid, SIGKILL);
    }
    if (unplugged_s != 0.0 && replugged_s == 0.0 && seconds > unplugged_s + 0.5) {
      replugged_s = seconds;
      EXPECT_TRUE(devices.Spawn(PythonDevice(options.out / "device_2.log", kPort)));
    }
  };
  const scene::Scenario scenario = Load("touch");
  const auto outcome = oos::RunSession(scenario, options);
  ASSERT_TRUE(outcome) << outcome.error().detail;
  EXPECT_TRUE(outcome->is_final) << outcome->why;
  EXPECT_GT(replugged_s, 0.0) << "it never pressed";
  EXPECT_TRUE(HasEvent(*outcome, "device_lost", "example in Python"));
  EXPECT_TRUE(HasEvent(*outcome, "device_found", "example in Python 1 is alive"));
  const nlohmann::json report = ReadReport(options.out / "device_bridge.json");
  ASSERT_TRUE(report.is_object());
  EXPECT_EQ(report["samples_over_cap"], 0);
  EXPECT_LE(report["peak_force_N"].get<double>(), 20.0) << "the device's own limit";
  EXPECT_FALSE(report["roles"][0]["is_simulated"].get<bool>());
}

// Its joints are what a viewer of that session recorded: a robot's, also of a device with a thread of its own.
TEST(Devices, ARobotIsShownWithoutAScene) {
  const auto out = std::filesystem::path(VR_OOS_BINARY_DIR) / "devices" / "view";
  std::filesystem::remove_all(out);
  const auto run = process::RunHere({VR_OOS_BINARY_DIR "/bin/oos", "device", "view",
                                     "plugin:" VR_OOS_BINARY_DIR "/test_plugins/faulty_device.so", "--headless",
                                     "--duration", "3", "--out", out.string()});
  ASSERT_TRUE(run) << run.error().detail;
  EXPECT_NE(run->out.find("limit of 3 s reached"), std::string::npos) << run->out << run->err;
  std::size_t num_joints = 0;
  ASSERT_TRUE(bus::log::ReadMcap(out / "scene.mcap",
                                 [&](const bus::log::Channel& channel, const bus::log::Message& /*message*/) {
                                   if (channel.topic == bus::DeviceJointsTopic("right")) ++num_joints;
                                 }));
  EXPECT_GT(num_joints, 30u) << "30 a second for 3 s";
}

}  // namespace
}  // namespace system_tests
