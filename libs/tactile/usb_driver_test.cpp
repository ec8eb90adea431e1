#include "tactile/usb_driver.hpp"

#include <gtest/gtest.h>

#include "core/clock.hpp"
#include "tactile/simulated_usb.hpp"

namespace tactile {
namespace {

// A bracelet in memory, its driver, and a clock that the test moves. Strengths are given every 4 ms, as the bridge
// does.
class UsbDriverTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto table = ReadUsbTable(VR_OOS_SOURCE_DIR "/scenarios/touch/vibrotac.xml");
    ASSERT_TRUE(table);
    driver_ = std::make_unique<UsbDriver>(*table, device_.Connect());
  }

  // Until `is_reached` holds; the time that it took, or -1 ms after `most_ms`.
  template <class Condition>
  double RunUntil(double most_ms, const Condition& is_reached) {
    const std::int64_t begin_ns = now_ns_;
    while (now_ns_ - begin_ns <= static_cast<std::int64_t>(most_ms * 1e6)) {
      if (is_reached()) return static_cast<double>(now_ns_ - begin_ns) * 1e-6;
      now_ns_ += core::kMillisecond_ns;
      if (now_ns_ % UsbDriver::kTurn_ns != 0) continue;
      if (is_fed_) driver_->Take(Strengths{strengths_, now_ns_});
      driver_->Turn(now_ns_);
    }
    return -1.0;
  }
  void Run(double ms) {
    RunUntil(ms, [] { return false; });
  }
  void Vibrate(float level) { strengths_[2] = level; }
  double sum() const { return device_.motors().sum(); }

  std::int64_t now_ns_ = 1'000'000'000;
  SimulatedUsb device_{[this] { return now_ns_; }};
  std::unique_ptr<UsbDriver> driver_;
  std::array<float, core::kMaxTactileChannels> strengths_{};
  bool is_fed_ = true;
};

TEST_F(UsbDriverTest, FindsTheDeviceSetsItUpAndLeavesItSilent) {
  Run(20);
  EXPECT_EQ(driver_->state().status, DriverStatus::kAlive);
  EXPECT_EQ(device_.motors().levels, std::vector<float>(6, 0.0f)) << "whatever it did before";
}

TEST_F(UsbDriverTest, AStrengthIsAtTheMotorWithin8ms) {
  Run(100);
  Vibrate(0.6f);
  const double delay_ms = RunUntil(100, [&] { return sum() > 0.5; });
  EXPECT_GE(delay_ms, 0.0);
  EXPECT_LE(delay_ms, 8.0);
}

TEST_F(UsbDriverTest, SilenceStopsTheMotorsWithin60ms) {
  Vibrate(1.0f);
  Run(100);
  ASSERT_GT(sum(), 0.9);
  is_fed_ = false;
  const double silence_ms = RunUntil(200, [&] { return sum() == 0.0; });
  EXPECT_GE(silence_ms, 0.0);
  EXPECT_LE(silence_ms, 60.0);
}

TEST_F(UsbDriverTest, ADriverThatDiesLeavesTheMotorsToTheDevicesWatchdog) {
  Vibrate(1.0f);
  Run(100);
  const std::int64_t died_ns = now_ns_;
  while (sum() > 0.0 && now_ns_ - died_ns < 1000 * core::kMillisecond_ns) now_ns_ += core::kMillisecond_ns;
  EXPECT_LE(now_ns_ - died_ns, 61 * core::kMillisecond_ns);
}

TEST_F(UsbDriverTest, AStalledEndpointIsClearedAndTheMotorRunsOn) {
  Vibrate(0.5f);
  Run(100);
  device_.Stall();
  Vibrate(1.0f);
  const double delay_ms = RunUntil(100, [&] { return sum() > 0.9; });
  EXPECT_GE(delay_ms, 0.0);
  EXPECT_LE(delay_ms, 20.0);
  EXPECT_EQ(driver_->state().errors, 1u);
  EXPECT_EQ(driver_->state().status, DriverStatus::kAlive);
}

TEST_F(UsbDriverTest, ADeviceThatTakesNothingIsToldAndOpenedAnew) {
  Vibrate(0.5f);
  Run(100);
  device_.Swallow(true);
  Run(20);
  EXPECT_EQ(driver_->state().status, DriverStatus::kNotAnswering);
  const std::uint64_t scans = device_.motors().scans;
  Run(1000);
  EXPECT_GT(device_.motors().scans, scans);
  device_.Swallow(false);
  Run(250);
  EXPECT_EQ(driver_->state().status, DriverStatus::kAlive);
  EXPECT_GT(sum(), 0.4);
}

TEST_F(UsbDriverTest, UnpluggedWhileItVibratesItIsLookedFor4TimesASecondAndGoesOn) {
  Vibrate(0.5f);
  Run(100);
  device_.Plug(false);
  Run(30);
  EXPECT_EQ(driver_->state().status, DriverStatus::kGone);
  const std::uint64_t scans = device_.motors().scans;
  Run(1000);
  EXPECT_GE(device_.motors().scans - scans, 4u);
  device_.Plug(true);
  const double back_ms = RunUntil(1000, [&] { return sum() > 0.4; });
  EXPECT_GE(back_ms, 0.0);
  EXPECT_LE(back_ms, 250.0);
  is_fed_ = false;
  Run(100);
  EXPECT_EQ(sum(), 0.0) << "set up anew";
}

TEST_F(UsbDriverTest, UnpluggedWhileItIsOffIsNoticedToo) {
  Run(100);
  device_.Plug(false);
  EXPECT_GE(RunUntil(250, [&] { return driver_->state().status == DriverStatus::kGone; }), 0.0);
}

TEST_F(UsbDriverTest, AtItsEndTheMotorsAreOff) {
  Vibrate(1.0f);
  Run(100);
  driver_->Stop();
  EXPECT_EQ(sum(), 0.0);
}

}  // namespace
}  // namespace tactile
