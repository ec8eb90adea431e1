#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "core/clock.hpp"
#include "device/builtin.hpp"
#include "device/frame.hpp"
#include "device/testing/fake_udp_device.hpp"

namespace device {
namespace {

class UdpPluginTest : public ::testing::Test {
 protected:
  void SetUp() override {
    port_ = FreeUdpPort();
    ASSERT_EQ(Open(std::to_string(port_)), OOS_DEVICE_OK) << why_;
  }
  void TearDown() override {
    if (device_ != nullptr) plugin_.close(device_);
  }
  int Open(const std::string& address) {
    oos_device_setting setting{};
    setting.size = sizeof setting;
    setting.role = "right";
    setting.address = address.c_str();
    setting.why = why_;
    setting.why_size = sizeof why_;
    return plugin_.open(&setting, &device_);
  }
  // Loopback delivers before sendto returns.
  oos_device_state Step(std::int64_t now_ns, const oos_device_command* command = nullptr) {
    oos_device_state state{};
    EXPECT_EQ(plugin_.step(device_, now_ns, command, nullptr, &state), OOS_DEVICE_OK);
    return state;
  }

  const oos_device_plugin& plugin_ = UdpPlugin();
  void* device_ = nullptr;
  std::uint16_t port_ = 0;
  char why_[200] = "";
};

TEST_F(UdpPluginTest, StatesCommandsAndReflectedSequencesGoBothWays) {
  const FakeUdpDevice fake(port_);
  EXPECT_EQ(Step(1 * core::kMillisecond_ns).sequence, 0U);
  fake.SendState(1);
  EXPECT_EQ(Step(2 * core::kMillisecond_ns).X_BD[4], 1.0);
  oos_device_command command{};
  command.sequence = 40;
  command.F_Do_B[0] = 2.5;
  Step(3 * core::kMillisecond_ns, &command);
  ReadFrame received;
  ASSERT_TRUE(fake.Receive(&received));
  EXPECT_EQ(received.command.F_Do_B[0], 2.5);
  EXPECT_EQ(received.header.reflected, 1U);
  EXPECT_EQ(received.command_flags, kDescribeYourself);
  fake.SendState(2, received.header.sequence);
  EXPECT_EQ(Step(4 * core::kMillisecond_ns).reflected, 40U);
  // A description ends the asking, and cannot claim what a foreign device must not be.
  oos_device_description description{};
  std::strcpy(description.name, "fake");
  description.flags = OOS_DEVICE_TAKES_HAND | OOS_DEVICE_IS_IMMEDIATE | OOS_DEVICE_TELLS_VELOCITY;
  EXPECT_EQ(plugin_.describe(device_, &description), OOS_DEVICE_GONE);
  fake.Send(EncodeDescription({FrameKind::kDescription, 1, 0, 1}, description));
  Step(5 * core::kMillisecond_ns, &command);
  ASSERT_EQ(plugin_.describe(device_, &description), OOS_DEVICE_OK);
  EXPECT_EQ(description.flags, static_cast<std::uint32_t>(OOS_DEVICE_TELLS_VELOCITY));
  ASSERT_TRUE(fake.Receive(&received));
  EXPECT_EQ(received.command_flags, 0U);
}

TEST_F(UdpPluginTest, OldFramesAreRefusedAndLostOnesCounted) {
  const FakeUdpDevice fake(port_);
  for (const std::uint32_t sequence : {1U, 2U, 5U, 4U, 5U, 3U, 6U}) fake.SendState(sequence);
  const oos_device_state state = Step(1 * core::kMillisecond_ns);
  EXPECT_EQ(state.X_BD[4], 6.0);
  EXPECT_EQ(state.sequence, 4U) << "1, 2, 5, 6";
  EXPECT_EQ(state.lost, 2U) << "3 and 4 came too late";
}

TEST_F(UdpPluginTest, ASecondDeviceAtThePortIsIgnoredUntilTheFirstIsSilent) {
  const FakeUdpDevice first(port_), second(port_);
  first.SendState(1);
  Step(1 * core::kMillisecond_ns);
  second.SendState(500);
  EXPECT_EQ(Step(50 * core::kMillisecond_ns).X_BD[4], 1.0);
  second.SendState(501);
  EXPECT_EQ(Step(200 * core::kMillisecond_ns).X_BD[4], 501.0);
  first.SendState(2);
  EXPECT_EQ(Step(201 * core::kMillisecond_ns).X_BD[4], 501.0);
}

TEST_F(UdpPluginTest, ARestartedDeviceMayCountFromOneAgain) {
  const FakeUdpDevice fake(port_);
  fake.SendState(1000);
  Step(1 * core::kMillisecond_ns);
  fake.SendState(1);
  EXPECT_EQ(Step(2 * core::kMillisecond_ns).X_BD[4], 1000.0);
  fake.SendState(2);
  EXPECT_EQ(Step(300 * core::kMillisecond_ns).X_BD[4], 2.0);
}

TEST_F(UdpPluginTest, AStepTakesABoundedShareOfAFlood) {
  const FakeUdpDevice fake(port_);
  for (std::uint32_t i = 1; i <= 200; ++i) fake.SendState(i);
  EXPECT_EQ(Step(1 * core::kMillisecond_ns).X_BD[4], 64.0);
  EXPECT_EQ(Step(2 * core::kMillisecond_ns).X_BD[4], 128.0);
}

TEST_F(UdpPluginTest, ABadAddressIsRefusedWithTheRemedy) {
  plugin_.close(device_);
  device_ = nullptr;
  for (const char* address : {"", "x", "0", "70000", "localhost:7460", "1.2.3:7460"}) {
    EXPECT_EQ(Open(address), OOS_DEVICE_BAD_SETTING) << address;
    EXPECT_NE(std::string(why_).find("write a port"), std::string::npos);
  }
}

}  // namespace
}  // namespace device
