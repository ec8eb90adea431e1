#include "tracking/plugin.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>
#include <utility>
#include <vector>

#include "device/testing/fake_udp_device.hpp"

namespace tracking {
namespace {

constexpr std::int64_t kMs = 1'000'000;
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

TEST_F(DtrackPluginTest, AFlysticksTriggerHoldsAndItsStickClosesTheJaws) {
  ASSERT_EQ(Open({{"flystick", "1"}}), OOS_DEVICE_OK) << why_;
  oos_device_description none{};
  EXPECT_EQ(plugin_.describe(device_, &none), OOS_DEVICE_GONE) << "nothing has come";
  const auto Send = [&](const std::string& keys) {
    controller_.Send(std::string("fr 1\r\nts 5.25\r\n6df2 2 2 [0 1.0 6 2][9 9 9]") + kUnturned +
                     "[0 0.00 0.00] [1 1.0 6 2][100 200 -300]" + kUnturned + keys + "\r\n");
  };
  Send("[0 0.50 0.00]");
  oos_device_state state = Step(1 * kMs);
  EXPECT_EQ(state.flags, 0U);
  EXPECT_EQ(state.opening_m, 0.08) << "the stick is in its middle";
  EXPECT_EQ(state.X_BD[4], 0.1);
  EXPECT_EQ(state.X_BD[6], -0.3);
  EXPECT_EQ(state.device_time_ns, 5'250'000'000);
  Send("[1 0.00 -0.75]");
  state = Step(2 * kMs);
  EXPECT_EQ(state.flags, static_cast<std::uint32_t>(OOS_DEVICE_IS_ENGAGED));
  EXPECT_EQ(state.buttons, 1U);
  EXPECT_NEAR(state.opening_m, 0.02, 1e-12);
  EXPECT_EQ(state.sequence, 2U);
  EXPECT_EQ(Step(3 * kMs).sequence, 2U) << "no frame";
  EXPECT_STREQ(Described().serial, "1");
  EXPECT_EQ(Described().actuated, 0U);
}

// Its place is zeros then, and must not move the hand; what its buttons say still counts, but for the dead-man.
TEST_F(DtrackPluginTest, WhatTheCamerasDoNotSeeIsLetGoAndStaysWhereItWas) {
  ASSERT_EQ(Open({}), OOS_DEVICE_OK) << why_;
  controller_.Send(std::string("6df2 1 1 [0 1.0 6 2][100 200 300]") + kUnturned + "[1 0 0]");
  EXPECT_EQ(Step(1 * kMs).flags, static_cast<std::uint32_t>(OOS_DEVICE_IS_ENGAGED));
  controller_.Send("6df2 1 1 [0 -1.0 6 2][0 0 0][0 0 0 0 0 0 0 0 0][3 0 0]");
  const oos_device_state state = Step(2 * kMs);
  EXPECT_EQ(state.sequence, 2U) << "the link is good";
  EXPECT_EQ(state.flags, 0U);
  EXPECT_EQ(state.X_BD[5], 0.2);
  EXPECT_EQ(state.X_BD[0], 1.0);
  EXPECT_EQ(state.buttons, 3U);
}

// Tips 50 mm apart, with radii of 8 and 12 mm.
TEST_F(DtrackPluginTest, AHandsJawsAreAsFarApartAsThumbAndIndexFinger) {
  ASSERT_EQ(Open({{"hand", "2"}, {"opening_max_m", "0.06"}}), OOS_DEVICE_OK) << why_;
  const auto Send = [&](double apart_mm) {
    const std::string rest = " 20 0 20 0 40]";
    controller_.Send(std::string("gl 1 [2 1.0 1 3][0 0 1000]") + kUnturned + "[10 20 30]" + kUnturned + "[8" + rest +
                     "[10 20 " + std::to_string(30.0 + apart_mm) + "]" + kUnturned + "[12" + rest + "[0 0 0]" +
                     kUnturned + "[9" + rest);
  };
  Send(50.0);
  oos_device_state state = Step(1 * kMs);
  EXPECT_EQ(state.flags, static_cast<std::uint32_t>(OOS_DEVICE_IS_ENGAGED));
  EXPECT_NEAR(state.opening_m, 0.03, 1e-9);
  EXPECT_EQ(state.X_BD[6], 1.0);
  Send(10.0);
  EXPECT_EQ(Step(2 * kMs).opening_m, 0.0);
  Send(200.0);
  EXPECT_EQ(Step(3 * kMs).opening_m, 0.06);
}

TEST_F(DtrackPluginTest, FingersVibrateWithTheForceOfTheJawsUntilTheBridgeFallsSilent) {
  ASSERT_EQ(Open({{"hand", "0"}, {"tactile", controller_.address()}}), OOS_DEVICE_OK) << why_;
  Step(1 * kMs);
  EXPECT_EQ(controller_.Heard(), "") << "no hand yet";
  controller_.Send(std::string("gl 1 [0 1.0 1 0][0 0 0]") + kUnturned);
  oos_device_command command{};
  command.grip_force_N = 4.0;
  Step(2 * kMs, &command);
  EXPECT_EQ(controller_.Heard(), "tfb 2 [0 0 1.00 0.40] [0 1 1.00 0.40]");
  Step(10 * kMs, &command);
  EXPECT_EQ(controller_.Heard(), "") << "thirty a second";
  command.grip_force_N = -50.0;
  Step(60 * kMs, &command);
  EXPECT_EQ(controller_.Heard(), "tfb 2 [0 0 1.00 1.00] [0 1 1.00 1.00]");
  Step(121 * kMs);
  EXPECT_EQ(controller_.Heard(), "tfb 2 [0 0 1.00 0.00] [0 1 1.00 0.00]");
}

TEST_F(DtrackPluginTest, SaysWhichOptionIsWrong) {
  using Options = std::vector<std::pair<std::string, std::string>>;
  for (const auto& [options, part] :
       {std::pair{Options{{"flystick", "left"}}, "option flystick: 'left' is not the number"},
        {Options{{"hand", "-1"}}, "option hand: '-1'"},
        {Options{{"hand", "0"}, {"flystick", "0"}}, "not both"},
        {Options{{"opening_max_m", "80"}}, "option opening_max_m: '80'"},
        {Options{{"hand", "0"}, {"tactile", "50110"}}, "192.168.0.1:50110"},
        {Options{{"tactile", "10.0.0.1:50110"}}, "for a hand"}}) {
    EXPECT_EQ(Open(options), OOS_DEVICE_BAD_SETTING) << part;
    EXPECT_NE(std::string(why_).find(part), std::string::npos) << why_;
  }
  port_ = 0;
}

}  // namespace
}  // namespace tracking
