#include "tracking/plugin.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "core/clock.hpp"
#include "device/testing/fake_udp_device.hpp"

namespace tracking {
namespace {

constexpr const char* kUnturned = "[1 0 0 0 1 0 0 0 1]";

// A controller: it sends frames to a port, and hears what comes to its own.
class Controller {
 public:
  explicit Controller(std::uint16_t to) : socket_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in here = Loopback(0);
    socklen_t size = sizeof here;
    EXPECT_EQ(bind(socket_, reinterpret_cast<const sockaddr*>(&here), sizeof here), 0);
    EXPECT_EQ(getsockname(socket_, reinterpret_cast<sockaddr*>(&here), &size), 0);
    port_ = ntohs(here.sin_port);
    to_ = Loopback(to);
  }
  ~Controller() { close(socket_); }
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;
  // Loopback has delivered it on return.
  void Send(const std::string& text) const {
    EXPECT_EQ(sendto(socket_, text.data(), text.size(), 0, reinterpret_cast<const sockaddr*>(&to_), sizeof to_),
              static_cast<ssize_t>(text.size()));
  }
  // The newest datagram; empty: none.
  [[nodiscard]] std::string Heard() const {
    std::string newest;
    char bytes[256];
    for (ssize_t size = 0; (size = recv(socket_, bytes, sizeof bytes, MSG_DONTWAIT)) > 0;) {
      newest.assign(bytes, static_cast<std::size_t>(size));
    }
    return newest;
  }
  [[nodiscard]] std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

 private:
  static sockaddr_in Loopback(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port);
    return address;
  }
  int socket_;
  std::uint16_t port_ = 0;
  sockaddr_in to_{};
};

class DtrackPluginTest : public ::testing::Test {
 protected:
  void TearDown() override {
    if (device_ != nullptr) plugin_.close(device_);
  }
  int Open(std::vector<std::pair<std::string, std::string>> options) {
    options_ = std::move(options);
    std::vector<oos_device_option> list;
    for (const auto& [name, value] : options_) list.push_back({name.c_str(), value.c_str()});
    oos_device_setting setting{};
    setting.size = sizeof setting;
    setting.role = "right";
    const std::string address = std::to_string(port_);
    setting.address = address.c_str();
    setting.options = list.data();
    setting.num_options = static_cast<std::uint32_t>(list.size());
    setting.why = why_;
    setting.why_size = sizeof why_;
    return plugin_.open(&setting, &device_);
  }
  oos_device_state Step(std::int64_t now_ns, const oos_device_command* command = nullptr) {
    oos_device_state state{};
    state.size = sizeof state;
    EXPECT_EQ(plugin_.step(device_, now_ns, command, nullptr, &state), OOS_DEVICE_OK);
    return state;
  }
  oos_device_description Described() {
    oos_device_description description{};
    description.size = sizeof description;
    EXPECT_EQ(plugin_.describe(device_, &description), OOS_DEVICE_OK);
    return description;
  }

  const oos_device_plugin& plugin_ = Plugin();
  std::uint16_t port_ = device::FreeUdpPort();
  Controller controller_{port_};
  void* device_ = nullptr;
  std::vector<std::pair<std::string, std::string>> options_;
  char why_[300] = "";
};

// Up opens, the middle closes without a force, down presses: on what is 20 mm wide and gives 8 kN/m.
TEST_F(DtrackPluginTest, AFlysticksTriggerHoldsAndItsStickGrips) {
  ASSERT_EQ(Open({{"flystick", "1"}}), OOS_DEVICE_OK) << why_;
  oos_device_description none{};
  EXPECT_EQ(plugin_.describe(device_, &none), OOS_DEVICE_GONE) << "nothing has come";
  const auto Send = [&](const std::string& keys) {
    controller_.Send(std::string("fr 1\r\nts 5.25\r\n6df2 2 2 [0 1.0 6 2][9 9 9]") + kUnturned +
                     "[0 0.00 0.00] [1 1.0 6 2][100 200 -300]" + kUnturned + keys + "\r\n");
  };
  Send("[0 0.50 0.00]");
  oos_device_state state = Step(1 * core::kMillisecond_ns);
  EXPECT_EQ(state.flags, 0U);
  EXPECT_EQ(state.X_BD[4], 0.1);
  EXPECT_EQ(state.X_BD[6], -0.3);
  EXPECT_EQ(state.device_time_ns, 5'250'000'000);
  Send("[1 0.00 1.00]");
  state = Step(2 * core::kMillisecond_ns);
  EXPECT_EQ(state.flags, static_cast<std::uint32_t>(OOS_DEVICE_IS_ENGAGED));
  EXPECT_EQ(state.buttons, 1U);
  EXPECT_EQ(state.sequence, 2U);
  EXPECT_STREQ(Described().serial, "1");
  EXPECT_EQ(Described().actuated, 0U);

  const double width_m = 0.02, stiffness_N_per_m = 8000.0;
  std::int64_t now_ns = 2 * core::kMillisecond_ns;
  double pressed_N = 0.0;
  const auto GripFor = [&](const std::string& keys, int ticks) {
    for (int i = 0; i < ticks; ++i) {
      if (i % 16 == 0) Send(keys);
      oos_device_command command{};
      pressed_N = command.grip_force_N = stiffness_N_per_m * std::max(0.0, width_m - state.opening_m);
      state = Step(now_ns += core::kMillisecond_ns, &command);
    }
  };
  GripFor("[1 0.00 1.00]", 1000);
  EXPECT_EQ(state.opening_m, 0.08);
  GripFor("[1 0.00 0.00]", 2000);
  EXPECT_NEAR(state.opening_m, width_m, 1e-5);
  EXPECT_LT(pressed_N, 0.1);
  GripFor("[1 0.00 -0.50]", 1000);
  EXPECT_NEAR(pressed_N, 20.0, 0.01);
  GripFor("[1 0.00 -1.00]", 1000);
  EXPECT_NEAR(pressed_N, 40.0, 0.01);
  GripFor("[1 0.00 0.25]", 1000);
  EXPECT_NEAR(state.opening_m, width_m, 1e-9) << "a quarter of 80 mm";
}

// The jaws go on between two frames; a tracker that has fallen silent gives no more samples.
TEST_F(DtrackPluginTest, EachStepIsASampleUntilFramesStayAway) {
  ASSERT_EQ(Open({}), OOS_DEVICE_OK) << why_;
  const auto Send = [&](double x_mm, const std::string& time) {
    controller_.Send("ts " + time + "\r\n6df2 1 1 [0 1.0 6 2][" + std::to_string(x_mm) + " 0 0]" + kUnturned +
                     "[1 0 0]");
  };
  Send(0.0, "1.000");
  EXPECT_EQ(Step(100 * core::kMillisecond_ns).sequence, 1U);
  Send(3.0, "1.020");
  oos_device_state state = Step(120 * core::kMillisecond_ns);
  EXPECT_EQ(state.sequence, 2U);
  EXPECT_NEAR(state.V_BD[3], 0.15, 1e-9) << "3 mm in 20 ms";
  state = Step(125 * core::kMillisecond_ns);
  EXPECT_EQ(state.sequence, 3U);
  EXPECT_EQ(state.device_time_ns, 1'025'000'000);
  EXPECT_NEAR(state.X_BD[4], 0.003, 1e-12);
  EXPECT_EQ(Step(171 * core::kMillisecond_ns).sequence, 3U);
}

// Its place is zeros then, and must not move the hand; what its buttons say still counts, but for the dead-man.
TEST_F(DtrackPluginTest, WhatTheCamerasDoNotSeeIsLetGoAndStaysWhereItWas) {
  ASSERT_EQ(Open({}), OOS_DEVICE_OK) << why_;
  controller_.Send(std::string("6df2 1 1 [0 1.0 6 2][100 200 300]") + kUnturned + "[1 0 0]");
  EXPECT_EQ(Step(1 * core::kMillisecond_ns).flags, static_cast<std::uint32_t>(OOS_DEVICE_IS_ENGAGED));
  controller_.Send("6df2 1 1 [0 -1.0 6 2][0 0 0][0 0 0 0 0 0 0 0 0][3 0 0]");
  const oos_device_state state = Step(2 * core::kMillisecond_ns);
  EXPECT_EQ(state.sequence, 2U) << "the link is good";
  EXPECT_EQ(state.flags, 0U);
  EXPECT_EQ(state.X_BD[5], 0.2);
  EXPECT_EQ(state.X_BD[0], 1.0);
  EXPECT_EQ(state.buttons, 3U);
}

// Tips 50 mm apart, with radii of 8 and 12 mm.
TEST_F(DtrackPluginTest, AHandsJawsGoWhereThumbAndIndexFingerAre) {
  ASSERT_EQ(Open({{"hand", "2"}, {"opening_max_m", "0.06"}}), OOS_DEVICE_OK) << why_;
  const auto Send = [&](double apart_mm) {
    const std::string rest = " 20 0 20 0 40]";
    controller_.Send(std::string("gl 1 [2 1.0 1 3][0 0 1000]") + kUnturned + "[10 20 30]" + kUnturned + "[8" + rest +
                     "[10 20 " + std::to_string(30.0 + apart_mm) + "]" + kUnturned + "[12" + rest + "[0 0 0]" +
                     kUnturned + "[9" + rest);
  };
  std::int64_t now_ns = 0;
  double pressed_N = 0.0;
  oos_device_state state{};
  const auto StepFor = [&](double apart_mm, double width_m) {
    for (int i = 0; i < 1000; ++i) {
      if (i % 16 == 0) Send(apart_mm);
      oos_device_command command{};
      pressed_N = command.grip_force_N = 8000.0 * std::max(0.0, width_m - state.opening_m);
      state = Step(now_ns += core::kMillisecond_ns, &command);
    }
  };
  StepFor(50.0, 0.0);
  EXPECT_EQ(state.flags, static_cast<std::uint32_t>(OOS_DEVICE_IS_ENGAGED));
  EXPECT_NEAR(state.opening_m, 0.03, 1e-9);
  EXPECT_EQ(state.X_BD[6], 1.0);
  StepFor(10.0, 0.0);
  EXPECT_NEAR(state.opening_m, 0.0, 1e-9);
  StepFor(200.0, 0.0);
  EXPECT_NEAR(state.opening_m, 0.06, 1e-9);
  // What is 25 mm wide stops the jaws; fingers 5 mm nearer press by two springs in a row, of 3 and 8 kN/m.
  StepFor(40.0, 0.025);
  EXPECT_NEAR(pressed_N, 0.005 / (1.0 / 3000.0 + 1.0 / 8000.0), 0.01);
  StepFor(60.0, 0.025);
  EXPECT_EQ(pressed_N, 0.0);
}

// A sensor says how strongly, whatever is between the jaws; when it falls silent nothing is pressed.
TEST_F(DtrackPluginTest, AHandWithASensorPressesAsItPinches) {
  const std::uint16_t sensor_port = device::FreeUdpPort();
  ASSERT_EQ(Open({{"hand", "0"}, {"pinch", std::to_string(sensor_port)}, {"max_grip_N", "20"}}), OOS_DEVICE_OK) << why_;
  const Controller sensor(sensor_port);
  std::int64_t now_ns = 0;
  double pressed_N = 0.0;
  oos_device_state state{};
  const auto StepFor = [&](const std::string& pinch, int ticks) {
    for (int i = 0; i < ticks; ++i) {
      if (i % 16 == 0) {
        controller_.Send(std::string("gl 1 [0 1.0 0 2][0 0 0]") + kUnturned + "[0 0 0]" + kUnturned +
                         "[9 20 0 20 0 40][0 0 18]" + kUnturned + "[9 20 0 20 0 40]");
        if (!pinch.empty()) sensor.Send(pinch);
      }
      oos_device_command command{};
      pressed_N = command.grip_force_N = 8000.0 * std::max(0.0, 0.03 - state.opening_m);
      state = Step(now_ns += core::kMillisecond_ns, &command);
    }
  };
  StepFor("pinch 2 [1 0.9 0.9 0.9 0.9] [0 0.1 0.4 0 0]", 2000);
  EXPECT_NEAR(pressed_N, 8.0, 0.01);
  StepFor("pinch 1 [0 0.1 0.4 0", 1000);  // cut off
  EXPECT_LT(pressed_N, 0.1);
  StepFor("pinch 1 [0 1 0 0 0]\r\n", 1000);
  EXPECT_NEAR(pressed_N, 20.0, 0.01);
  StepFor("", 1000);
  EXPECT_LT(pressed_N, 0.1);
}

// The cameras say where the palm is, and the glove where its fingers are; what is cut off changes nothing.
TEST_F(DtrackPluginTest, AGloveTellsTheAnglesOfTheFingers) {
  const std::uint16_t glove_port = device::FreeUdpPort();
  ASSERT_EQ(Open({{"body", "4"}, {"glove", std::to_string(glove_port)}}), OOS_DEVICE_OK) << why_;
  const Controller glove(glove_port);
  controller_.Send(std::string("6d 1 [4 1.0][100 200 300]") + kUnturned);
  EXPECT_EQ(Step(1 * core::kMillisecond_ns).num_finger_joints, 0U) << "nothing has come";
  glove.Send("glove 2 [1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1] [4 1.1 0.2 0 0.3 0 0 0.3 0 0 0.3 0 0 0.3 0 -0.1]\r\n");
  oos_device_state state = Step(2 * core::kMillisecond_ns);
  ASSERT_EQ(state.num_finger_joints, static_cast<std::uint32_t>(OOS_DEVICE_FINGER_JOINTS));
  EXPECT_EQ(state.finger_rad[0], 1.1);
  EXPECT_EQ(state.finger_rad[14], -0.1);
  EXPECT_EQ(state.X_BD[4], 0.1);
  glove.Send("glove 1 [4 0.5 0.5 0.5");
  state = Step(3 * core::kMillisecond_ns);
  EXPECT_EQ(state.finger_rad[0], 1.1);
  EXPECT_EQ(state.num_finger_joints, static_cast<std::uint32_t>(OOS_DEVICE_FINGER_JOINTS));
}

TEST_F(DtrackPluginTest, ATrackedHandTellsTheAnglesOfItsFingers) {
  ASSERT_EQ(Open({{"hand", "0"}}), OOS_DEVICE_OK) << why_;
  const std::string straight = std::string("[0 0 0]") + kUnturned + "[9 20 0 20 0 40]";
  const std::string bent =
      std::string("[0 0 18]") + "[0 0 -1 0 1 0 1 0 0]" + "[9 20 30 20 40 40]";  // its x is the hand's -z
  controller_.Send(std::string("gl 1 [0 1.0 0 3][0 0 0]") + kUnturned + straight + bent + straight);
  const oos_device_state state = Step(1 * core::kMillisecond_ns);
  ASSERT_EQ(state.num_finger_joints, static_cast<std::uint32_t>(OOS_DEVICE_FINGER_JOINTS));
  constexpr double kDegree = 0.017453292519943295;
  EXPECT_NEAR(state.finger_rad[3], 20.0 * kDegree, 1e-6);
  EXPECT_NEAR(state.finger_rad[4], 40.0 * kDegree, 1e-6);
  EXPECT_NEAR(state.finger_rad[5], 30.0 * kDegree, 1e-6);
  EXPECT_NEAR(state.finger_rad[6], 0.0, 1e-6);
}

// A forearm, say: followed while it is seen. DTrack's line has only bodies that are.
TEST_F(DtrackPluginTest, ABodyIsFollowedWhileTheCamerasSeeIt) {
  ASSERT_EQ(Open({{"body", "4"}}), OOS_DEVICE_OK) << why_;
  controller_.Send(std::string("fr 7\r\n6d 2 [1 1.0][9 9 9]") + kUnturned + " [4 1.0][100 200 300]" + kUnturned);
  oos_device_state state = Step(1 * core::kMillisecond_ns);
  EXPECT_EQ(state.flags, static_cast<std::uint32_t>(OOS_DEVICE_IS_ENGAGED));
  EXPECT_EQ(state.X_BD[5], 0.2);
  EXPECT_EQ(state.opening_m, 0.08) << "there is nothing to grip with";
  EXPECT_STREQ(Described().name, "body by ART DTrack");
  controller_.Send(std::string("fr 8\r\n6d 1 [1 1.0][9 9 9]") + kUnturned);
  state = Step(17 * core::kMillisecond_ns);
  EXPECT_EQ(state.flags, 0U);
  EXPECT_EQ(state.X_BD[5], 0.2);
}

TEST_F(DtrackPluginTest, FingersVibrateWithTheForceOfTheJawsUntilTheBridgeFallsSilent) {
  ASSERT_EQ(Open({{"hand", "0"}, {"tactile", controller_.address()}}), OOS_DEVICE_OK) << why_;
  Step(1 * core::kMillisecond_ns);
  EXPECT_EQ(controller_.Heard(), "") << "no hand yet";
  controller_.Send(std::string("gl 1 [0 1.0 1 0][0 0 0]") + kUnturned);
  oos_device_command command{};
  command.grip_force_N = 4.0;
  Step(2 * core::kMillisecond_ns, &command);
  EXPECT_EQ(controller_.Heard(), "tfb 2 [0 0 1.00 0.40] [0 1 1.00 0.40]");
  Step(10 * core::kMillisecond_ns, &command);
  EXPECT_EQ(controller_.Heard(), "") << "thirty a second";
  command.grip_force_N = -50.0;
  Step(60 * core::kMillisecond_ns, &command);
  EXPECT_EQ(controller_.Heard(), "tfb 2 [0 0 1.00 1.00] [0 1 1.00 1.00]");
  Step(121 * core::kMillisecond_ns);
  EXPECT_EQ(controller_.Heard(), "tfb 2 [0 0 1.00 0.00] [0 1 1.00 0.00]");
}

TEST_F(DtrackPluginTest, SaysWhichOptionIsWrong) {
  using Options = std::vector<std::pair<std::string, std::string>>;
  for (const auto& [options, part] :
       {std::pair{Options{{"flystick", "left"}}, "option flystick: 'left' is not the number"},
        {Options{{"hand", "-1"}}, "option hand: '-1'"},
        {Options{{"hand", "0"}, {"flystick", "0"}}, "not two of them"},
        {Options{{"body", "two"}}, "option body: 'two'"},
        {Options{{"opening_max_m", "80"}}, "option opening_max_m: '80'"},
        {Options{{"hand", "0"}, {"tactile", "50110"}}, "192.168.0.1:50110"},
        {Options{{"max_grip_N", "strong"}}, "option max_grip_N: 'strong'"},
        {Options{{"hand", "0"}, {"grip_stiffness_N_per_m", "-3"}}, "option grip_stiffness_N_per_m: '-3'"},
        {Options{{"hand", "0"}, {"pinch", "here"}}, "option pinch: "},
        {Options{{"pinch", "5001"}}, "so give option hand"},
        {Options{{"hand", "0"}, {"glove", "here"}}, "option glove: "},
        {Options{{"tactile", "10.0.0.1:50110"}}, "for a hand"}}) {
    EXPECT_EQ(Open(options), OOS_DEVICE_BAD_SETTING) << part;
    EXPECT_NE(std::string(why_).find(part), std::string::npos) << why_;
  }
  port_ = 0;
}

}  // namespace
}  // namespace tracking
