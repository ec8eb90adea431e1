// The driver of tactile devices on the real libusb, and a session whose bridge is a process of its own.

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/clock.hpp"
#include "scene/load_scenario.hpp"
#include "tactile/libusb_transport.hpp"
#include "tactile/usb_driver.hpp"
#include "tests/usb_tactile/testing/emulated_usb_device.hpp"
#include "tools/oos/run/session/session.hpp"

namespace usb_tactile_tests {
namespace {

using Bytes = EmulatedUsbDevice::Bytes;
using tactile::DriverStatus;

class LibusbDriver : public testing::Test {
 protected:
  void SetUp() override {
    const auto table = tactile::ReadUsbTable(VR_OOS_SOURCE_DIR "/scenarios/touch/vibrotac.xml");
    ASSERT_TRUE(table);
    driver_ = std::make_unique<tactile::UsbDriver>(*table, tactile::MakeLibusbTransport());
  }

  // Turns, each with a fresh strength, until it holds.
  template <class Condition>
  bool RunUntil(const Condition& is_reached) {
    const std::int64_t begin_ns = core::MonotonicNow_ns();
    while (!is_reached()) {
      if (core::MonotonicNow_ns() - begin_ns > 30'000'000'000) return false;
      now_ns_ += tactile::UsbDriver::kTurn_ns;
      if (is_fed_) driver_->Take({strengths_, now_ns_});
      driver_->Turn(now_ns_);
    }
    return true;
  }
  bool RunUntilFrame(const Bytes& frame) {
    return RunUntil([&] { return !device_.frames().empty() && device_.frames().back() == frame; });
  }
  bool RunUntil(DriverStatus status) {
    return RunUntil([&] { return driver_->state().status == status; });
  }

  const Bytes kOff{0xa5, 0, 0, 0, 0, 0, 0, 0xa5};
  const Bytes kOn{0xa5, 0, 0xff, 0, 0, 0, 0, 0xa5 ^ 0xff};
  EmulatedUsbDevice device_;
  std::unique_ptr<tactile::UsbDriver> driver_;
  std::array<float, core::kMaxTactileChannels> strengths_{};
  bool is_fed_ = true;
  std::int64_t now_ns_ = 1'000'000'000;
};

TEST_F(LibusbDriver, FindsTheDeviceTellsItItsWatchdogAndSendsFrames) {
  for (int i = 0; i < 100; ++i) driver_->Turn(now_ns_ += tactile::UsbDriver::kTurn_ns);
  EXPECT_EQ(driver_->state().status, DriverStatus::kWaiting);
  device_.Plug();
  ASSERT_TRUE(RunUntil(DriverStatus::kAlive));
  ASSERT_FALSE(device_.setups().empty());
  EXPECT_EQ(device_.setups().front(), (Bytes{0x40, 1, 60, 0, 0, 0, 0, 0}));
  EXPECT_EQ(device_.frames().front(), kOff);
  strengths_[1] = 1.0f;
  EXPECT_TRUE(RunUntilFrame(kOn));
}

TEST_F(LibusbDriver, SilenceStopsTheMotors) {
  device_.Plug();
  strengths_[1] = 1.0f;
  ASSERT_TRUE(RunUntilFrame(kOn));
  is_fed_ = false;
  EXPECT_TRUE(RunUntilFrame(kOff));
}

TEST_F(LibusbDriver, AStalledEndpointIsCleared) {
  device_.Plug();
  ASSERT_TRUE(RunUntil(DriverStatus::kAlive));
  device_.Stall();
  strengths_[1] = 1.0f;
  EXPECT_TRUE(RunUntilFrame(kOn));
  EXPECT_EQ(device_.halts_cleared(), 1);
  EXPECT_EQ(driver_->state().errors, 1u);
}

TEST_F(LibusbDriver, ADeviceThatTakesNothingRunsIntoTheTimeOutAndComesBack) {
  device_.Plug();
  ASSERT_TRUE(RunUntil(DriverStatus::kAlive));
  device_.Swallow(true);
  strengths_[1] = 1.0f;
  EXPECT_TRUE(RunUntil(DriverStatus::kNotAnswering));
  device_.Swallow(false);
  EXPECT_TRUE(RunUntilFrame(kOn));
}

TEST_F(LibusbDriver, UnpluggedWhileItVibratesAndPluggedInAgainItGoesOn) {
  device_.Plug();
  strengths_[1] = 1.0f;
  ASSERT_TRUE(RunUntilFrame(kOn));
  device_.Unplug();
  EXPECT_TRUE(RunUntil(DriverStatus::kGone));
  const std::size_t frames = device_.frames().size();
  device_.Plug();
  ASSERT_TRUE(RunUntil(DriverStatus::kAlive));
  EXPECT_GT(device_.frames().size(), frames);
  EXPECT_TRUE(RunUntilFrame(kOn));
  EXPECT_EQ(device_.setups().size(), 2u) << "set up anew";
}

nlohmann::json ReadReport(const std::filesystem::path& file) {
  std::ifstream in(file);
  return nlohmann::json::parse(in, nullptr, false);
}

bool Contains(const std::filesystem::path& file, const std::string& text) {
  std::ifstream in(file);
  return std::string((std::istreambuf_iterator<char>(in)), {}).find(text) != std::string::npos;
}

bool HasLevels(const Bytes& frame) {
  return std::any_of(frame.begin() + 1, frame.end() - 1, [](std::uint8_t byte) { return byte != 0; });
}

// The built nodes in a session: the ball presses the plate, the bracelet vibrates, is unplugged meanwhile, and goes on.
TEST(TactileSession, WhatTheHandTouchesIsFeltByABraceletInAnotherProcess) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "the nodes' sanitizer and the preloaded library do not go together";
#endif
  EmulatedUsbDevice device;
  ASSERT_EQ(setenv("LD_PRELOAD", "libumockdev-preload.so.0", 1), 0);
  device.Plug();
  const auto scenario = scene::LoadScenario(VR_OOS_SOURCE_DIR "/scenarios/touch/bracelet.xml");
  ASSERT_TRUE(scenario);
  oos::SessionOptions options;
  options.out = std::filesystem::path(VR_OOS_BINARY_DIR) / "usb_tactile";
  std::filesystem::remove_all(options.out);
  std::filesystem::create_directories(options.out);
  options.without = {"visual_node"};
  options.program_folder = std::filesystem::path(VR_OOS_BINARY_DIR) / "bin";
  options.devices = {"bracelet=usb"};
  options.duration_s = 60.0;
  double unplugged_s = 0.0, replugged_s = 0.0;
  std::size_t frames_before = 0;
  options.while_running = [&](process::Group&, double seconds, double /*force_N*/) {
    const std::vector<Bytes> frames = device.frames();
    if (unplugged_s == 0.0 && !frames.empty() && HasLevels(frames.back())) {
      unplugged_s = seconds;
      frames_before = frames.size();
      device.Unplug();
    }
    // Once the bridge has noticed: the emulation may let it wait for a second.
    const bool is_noticed = Contains(options.out / "device_bridge.log", "bracelet: VibroTac is gone");
    if (unplugged_s != 0.0 && replugged_s == 0.0 && is_noticed) {
      replugged_s = seconds;
      device.Plug();
    }
  };
  const auto outcome = oos::RunSession(*scenario, options);
  unsetenv("LD_PRELOAD");
  ASSERT_TRUE(outcome) << outcome.error().detail;
  EXPECT_TRUE(outcome->is_final) << outcome->why;
  ASSERT_GT(unplugged_s, 0.0) << "it never vibrated";
  ASSERT_GT(replugged_s, 0.0) << "the bridge did not notice";
  const std::vector<Bytes> frames = device.frames();
  const bool vibrates_again = std::any_of(frames.begin() + static_cast<std::ptrdiff_t>(frames_before), frames.end(),
                                          [](const Bytes& frame) { return HasLevels(frame); });
  EXPECT_TRUE(vibrates_again) << "after it was plugged in again";
  EXPECT_FALSE(HasLevels(frames.back())) << "the motors are off at the end";
  std::size_t lost = 0, found = 0;
  for (const core::Event& event : outcome->events) {
    lost += event.name == "device_lost" && event.detail == "bracelet: VibroTac is gone" ? 1 : 0;
    found += event.name == "device_found" && event.detail == "bracelet: VibroTac is alive" ? 1 : 0;
  }
  EXPECT_EQ(lost, 1u);
  EXPECT_EQ(found, 2u);
  const nlohmann::json report = ReadReport(options.out / "device_bridge.json");
  ASSERT_TRUE(report.is_object());
  EXPECT_FALSE(report["tactile"][0]["is_simulated"].get<bool>());
  EXPECT_GT(report["tactile"][0]["touching_s"].get<double>(), 0.5);
}

}  // namespace
}  // namespace usb_tactile_tests
