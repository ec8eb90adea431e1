#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "device/builtin.hpp"
#include "device/cobs.hpp"
#include "device/frame.hpp"

namespace device {
namespace {

// A device at the other end of a pseudo-terminal.
class SerialPluginTest : public ::testing::Test {
 protected:
  void SetUp() override {
    line_ = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
    ASSERT_GE(line_, 0);
    ASSERT_EQ(grantpt(line_), 0);
    ASSERT_EQ(unlockpt(line_), 0);
    path_ = ptsname(line_);
  }
  void TearDown() override {
    if (device_ != nullptr) plugin_.close(device_);
    if (line_ >= 0) close(line_);
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
  void SendState(std::uint32_t sequence) const {
    oos_device_state state{};
    state.X_BD[0] = 1.0;
    state.X_BD[4] = sequence;
    std::uint8_t bytes[kMaxStuffed];
    const std::size_t size = Stuff(EncodeState({FrameKind::kState, sequence, 0, 1}, state).span(),
                                   std::span<std::uint8_t, kMaxStuffed>(bytes));
    ASSERT_EQ(write(line_, bytes, size), static_cast<ssize_t>(size));
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
  int line_ = -1;
  std::string path_;
  void* device_ = nullptr;
  char why_[200] = "";
};

TEST_F(SerialPluginTest, FramesGoBothWaysOverALine) {
  ASSERT_EQ(Open(path_ + ":115200"), OOS_DEVICE_OK) << why_;
  const std::uint8_t noise[] = {1, 2, 3, 0xFF, 0, 0};
  ASSERT_EQ(write(line_, noise, sizeof noise), static_cast<ssize_t>(sizeof noise));
  SendState(17);
  oos_device_state state{};
  ASSERT_EQ(StepUntil(17, &state), OOS_DEVICE_OK);
  EXPECT_EQ(state.X_BD[4], 17.0);

  oos_device_command command{};
  command.F_Do_B[1] = -3.0;
  plugin_.step(device_, 1'000'000, &command, nullptr, &state);
  Unstuffer unstuffer;
  ReadFrame frame;
  bool has_command = false;
  for (int i = 0; i < 200 && !has_command; ++i) {
    pollfd wait{line_, POLLIN, 0};
    poll(&wait, 1, 5);
    std::uint8_t byte = 0;
    while (!has_command && read(line_, &byte, 1) == 1) {
      has_command = unstuffer.Take(byte) && DecodeFrame(unstuffer.bytes(), &frame) == FrameFault::kNone;
    }
  }
  ASSERT_TRUE(has_command);
  EXPECT_EQ(frame.command.F_Do_B[1], -3.0);
}

TEST_F(SerialPluginTest, ALineThatIsUnpluggedIsGone) {
  ASSERT_EQ(Open(path_), OOS_DEVICE_OK) << why_;
  SendState(1);
  oos_device_state state{};
  ASSERT_EQ(StepUntil(1, &state), OOS_DEVICE_OK);
  close(line_);
  line_ = -1;
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
