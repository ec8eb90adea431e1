#include <gtest/gtest.h>
#include <poll.h>

#include <string>

#include "device/builtin.hpp"
#include "device/frame.hpp"
#include "device/testing/fake_serial_device.hpp"

namespace device {
namespace {

// A device at the other end of a pseudo-terminal.
class SerialPluginTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(line_.Plug());
    path_ = line_.path();
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
  // Steps until a state of that sequence is there: the terminal's driver passes bytes on in its own time.
  int StepUntil(std::uint32_t sequence, oos_device_state* state) {
    int result = OOS_DEVICE_OK;
    for (int i = 0; i < 1000 && result == OOS_DEVICE_OK; ++i) {
      pollfd wait{plugin_.wait_fd(device_), POLLIN, 0};
      poll(&wait, 1, 5);
      result = plugin_.step(device_, i, nullptr, nullptr, state);
      if (state->device_time_ns != 0 && state->X_BD[4] == sequence) break;
    }
    return result;
  }

  const oos_device_plugin& plugin_ = SerialPlugin();
  FakeSerialDevice line_;
  std::string path_;
  void* device_ = nullptr;
  char why_[200] = "";
};

TEST_F(SerialPluginTest, FramesGoBothWaysOverALine) {
  ASSERT_EQ(Open(path_ + ":115200"), OOS_DEVICE_OK) << why_;
  const std::uint8_t noise[] = {1, 2, 3, 0xFF, 0, 0};
  ASSERT_TRUE(line_.Write(noise));
  ASSERT_TRUE(line_.SendState(17));
  oos_device_state state{};
  ASSERT_EQ(StepUntil(17, &state), OOS_DEVICE_OK);
  EXPECT_EQ(state.X_BD[4], 17.0);

  oos_device_command command{};
  command.F_Do_B[1] = -3.0;
  plugin_.step(device_, 1'000'000, &command, nullptr, &state);
  ReadFrame frame;
  bool has_command = false;
  for (int i = 0; i < 200 && !has_command; ++i) {
    line_.Wait(5);
    has_command = line_.Receive(&frame);
  }
  ASSERT_TRUE(has_command);
  EXPECT_EQ(frame.command.F_Do_B[1], -3.0);
}

TEST_F(SerialPluginTest, ALineThatIsUnpluggedIsGone) {
  ASSERT_EQ(Open(path_), OOS_DEVICE_OK) << why_;
  ASSERT_TRUE(line_.SendState(1));
  oos_device_state state{};
  ASSERT_EQ(StepUntil(1, &state), OOS_DEVICE_OK);
  line_.Unplug();
  EXPECT_EQ(StepUntil(2, &state), OOS_DEVICE_GONE);
  plugin_.close(device_);
  device_ = nullptr;
  EXPECT_EQ(Open(path_), OOS_DEVICE_GONE) << "and can be opened again when it is back";
  EXPECT_NE(std::string(why_).find("plugged in"), std::string::npos) << why_;
}

TEST_F(SerialPluginTest, ABadSettingIsRefusedWithTheRemedy) {
  EXPECT_EQ(Open("ttyUSB0"), OOS_DEVICE_BAD_SETTING);
  EXPECT_EQ(Open(path_ + ":12"), OOS_DEVICE_BAD_SETTING);
  EXPECT_NE(std::string(why_).find("115200"), std::string::npos);
}

}  // namespace
}  // namespace device
