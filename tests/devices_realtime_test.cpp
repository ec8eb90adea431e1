// A device in another process takes part in a run: the example of docs/howto/own-device.md, in Python.

#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "bus/log/mcap_reader.hpp"
#include "bus/topics.hpp"
#include "device/calibration.hpp"
#include "tests/support.hpp"
#include "tools/oos/run/session/session.hpp"
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

struct UnpluggedRun {
  std::filesystem::path out;
  oos::SessionOutcome outcome;
  double replugged_s = 0.0;
};

// The device is unplugged (its process killed) while it presses, and plugged in again (started anew) half a second
// later. It is calibrated, so it then is where it says, and begins its path anew.
void RunUnplugged(UnpluggedRun* run) {
  constexpr int kPort = 27460;
  constexpr double kPressing_N = 3.0;
  oos::SessionOptions options = Options("unplugged", kPort);
  run->out = options.out;
  device::Calibration calibration;
  calibration.name = "example in Python";
  calibration.serial = "1";
  calibration.X_WB.translation = Load("touch").devices[0].X_WD_start.translation;
  ASSERT_TRUE(device::Keep(calibration, options.out / "calibrations"));
  ASSERT_EQ(setenv("VR_OOS_DEVICES", (options.out / "calibrations").c_str(), 1), 0);
  process::Group devices;
  ASSERT_TRUE(devices.Spawn(PythonDevice(options.out / "device_1.log", kPort)));
  double unplugged_s = 0.0;
  run->replugged_s = 0.0;
  options.while_running = [&](process::Group&, double seconds, double force_N) {
    if (unplugged_s == 0.0 && force_N > kPressing_N) {
      unplugged_s = seconds;
      kill(devices.children().front().pid, SIGKILL);
    }
    if (unplugged_s != 0.0 && run->replugged_s == 0.0 && seconds > unplugged_s + 0.5) {
      run->replugged_s = seconds;
      EXPECT_TRUE(devices.Spawn(PythonDevice(options.out / "device_2.log", kPort)));
    }
  };
  const auto outcome = oos::RunSession(Load("touch"), options);
  ASSERT_TRUE(outcome) << outcome.error().detail;
  run->outcome = *outcome;
}

TEST(Devices, APythonDeviceCarriesOutTouchAlthoughItIsUnpluggedMeanwhile) {
  constexpr int kRuns = 3;
  UnpluggedRun run;
  // The device follows its path without seeing the scene, so a busy machine leads it astray.
  for (int i = 0; i < kRuns && !run.outcome.is_final; ++i) ASSERT_NO_FATAL_FAILURE(RunUnplugged(&run));
  EXPECT_TRUE(run.outcome.is_final) << run.outcome.why;
  EXPECT_GT(run.replugged_s, 0.0) << "it never pressed";
  EXPECT_TRUE(HasEvent(run.outcome, "device_lost", "after its last sample"));
  EXPECT_TRUE(HasEvent(run.outcome, "device_found", "example in Python 1 is alive"));
  const nlohmann::json report = ReadReport(run.out / "device_bridge.json");
  ASSERT_TRUE(report.is_object());
  EXPECT_EQ(report["samples_over_cap"], 0);
  // In steps of the bridge, of which a busy machine makes fewer in a second, not more.
  const nlohmann::json& role = report["roles"][0];
  EXPECT_GE(role["device_losses"].get<int>(), 1);
  for (const char* notice : {"most_steps_to_device_lost", "most_steps_to_device_found"}) {
    EXPECT_GT(role[notice].get<int>(), 0) << notice;
    EXPECT_LE(role[notice].get<int>(), 1000) << notice;
  }
  EXPECT_LE(report["peak_force_N"].get<double>(), 20.0) << "the device's own limit";
  EXPECT_FALSE(report["roles"][0]["is_simulated"].get<bool>());
}

// What `oos device check` says of each subject, and its exit status.
struct CheckedDevice {
  std::map<std::string, std::string> verdicts;  // "OK", "FAIL" or "skip"
  int status = -1;
  std::string out;
};

// Of a Python program that is started for it.
CheckedDevice CheckPython(const std::string& name, const std::vector<std::string>& arguments, int port) {
  CheckedDevice checked;
  process::Command command = PythonDevice(std::filesystem::path(VR_OOS_BINARY_DIR) / (name + ".log"), port);
  command.arguments = arguments;
  process::Group devices;
  if (!devices.Spawn(command)) return checked;
  const auto run = process::RunHere({VR_OOS_BINARY_DIR "/bin/oos", "device", "check", "udp:" + std::to_string(port)});
  if (!run) return checked;
  checked.status = run->status;
  checked.out = run->out + run->err;
  std::istringstream lines(run->out);
  for (std::string line; std::getline(lines, line);) {
    // Verdict and subject stand in columns of 4 and 12.
    if (line.size() < 18 || line.substr(4, 2) != "  ") continue;
    const auto trimmed = [](std::string text) { return text.erase(text.find_last_not_of(' ') + 1); };
    checked.verdicts[trimmed(line.substr(6, 12))] = trimmed(line.substr(0, 4));
  }
  return checked;
}

// A busy machine stops a device for a moment and spoils a check. What comes of the device comes in each.
CheckedDevice CheckUntil(const std::map<std::string, std::string>& expected, const std::string& name,
                         const std::vector<std::string>& arguments, int port) {
  constexpr int kChecks = 3;
  CheckedDevice checked;
  const auto is_as_expected = [&](const auto& verdict) {
    const auto found = checked.verdicts.find(verdict.first);
    return found != checked.verdicts.end() && found->second == verdict.second;
  };
  for (int i = 0; i < kChecks && !std::all_of(expected.begin(), expected.end(), is_as_expected); ++i) {
    checked = CheckPython(name, arguments, port);
  }
  return checked;
}

// All but what a busy machine decides: rate, jitter, loss, round trip. It stands still until a scene pushes it, so its
// velocity cannot be told.
TEST(Devices, TheExampleInPythonPassesTheCheck) {
  constexpr int kPort = 27461;
  const std::map<std::string, std::string> expected{{"found", "OK"}, {"metres", "OK"}, {"nanoseconds", "OK"},
                                                    {"push", "OK"},  {"clamp", "OK"},  {"watchdog", "OK"}};
  const CheckedDevice checked =
      CheckUntil(expected, "checked_example",
                 {VR_OOS_SOURCE_DIR "/clients/python/example_device.py", std::to_string(kPort)}, kPort);
  for (const auto& [subject, verdict] : expected) {
    ASSERT_TRUE(checked.verdicts.contains(subject)) << subject << " is not in:\n" << checked.out;
    EXPECT_EQ(checked.verdicts.at(subject), verdict) << checked.out;
  }
  EXPECT_NE(checked.verdicts.at("velocity"), "FAIL") << checked.out;
  bool is_one_failed = false;
  for (const auto& [subject, verdict] : checked.verdicts) is_one_failed = is_one_failed || verdict == "FAIL";
  EXPECT_EQ(checked.status == 0, !is_one_failed) << checked.out;
}

// The rule that is broken is named, and those beside it hold.
TEST(Devices, AClientThatBreaksARuleFailsTheCheckInThatRule) {
  struct Rule {
    const char* fault;
    const char* fails;
    const char* holds;
  };
  int port = 27462;
  for (const Rule& rule : {Rule{"millimetres", "metres", "nanoseconds"}, Rule{"stalls", "jitter", "metres"},
                           Rule{"deaf", "push", "metres"}, Rule{"deadless", "watchdog", "push"}}) {
    const std::vector<std::string> bad{VR_OOS_SOURCE_DIR "/tests/bad_device.py", std::to_string(port), rule.fault};
    const CheckedDevice checked =
        CheckUntil({{rule.fails, "FAIL"}, {rule.holds, "OK"}}, std::string("checked_") + rule.fault, bad, port++);
    EXPECT_NE(checked.status, 0) << rule.fault;
    ASSERT_TRUE(checked.verdicts.contains(rule.fails)) << rule.fault << ":\n" << checked.out;
    EXPECT_EQ(checked.verdicts.at(rule.fails), "FAIL") << rule.fault << ":\n" << checked.out;
    EXPECT_EQ(checked.verdicts.at(rule.holds), "OK") << rule.fault << ":\n" << checked.out;
  }
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
