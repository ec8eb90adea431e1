#pragma once

#include <gtest/gtest.h>
#include <termios.h>

#include <cstring>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "core/wrench.hpp"
#include "device/testing/fake_haply_service.hpp"
#include "device/testing/fake_serial_device.hpp"
#include "device/testing/fake_udp_device.hpp"
#include "scene/scenario.hpp"

namespace device_bridge {

// What the other end of a device's link was told at last.
struct ToldCommand {
  core::Wrench F_Do_B;
  double grip_force_N = 0.0;
  double brake_N_s_per_m = 0.0;
  double brake_Nm_s_per_rad = 0.0;
};

// For tests: the other end of a link, in the time of its caller. It is held by a hand, can be unplugged, and plugged in
// again under the same address.
class WirePeer {
 public:
  virtual ~WirePeer() = default;
  // Type and address under which it is found.
  virtual void Name(scene::Device* device) const = 0;
  virtual void Plug() = 0;
  virtual void Unplug() = 0;
  // Takes what has come, and sends a sample, which has arrived on return.
  virtual void Serve(std::int64_t now_ns) = 0;

  [[nodiscard]] const ToldCommand& told() const { return told_; }
  [[nodiscard]] std::uint64_t num_told() const { return num_told_; }
  // Of the hand, in the base's frame.
  void SetTwist(const core::Twist& V_BD) { V_BD_ = V_BD; }
  void SetEngaged(bool is_engaged) { is_engaged_ = is_engaged; }

 protected:
  void Take(const oos_device_command& c) {
    told_ = {{{c.F_Do_B[0], c.F_Do_B[1], c.F_Do_B[2]}, {c.F_Do_B[3], c.F_Do_B[4], c.F_Do_B[5]}},
             c.grip_force_N,
             c.brake_N_s_per_m,
             c.brake_Nm_s_per_rad};
    ++num_told_;
  }
  void Forget() { sequence_ = 0; }
  device::Frame State(std::int64_t now_ns) {
    oos_device_state state{};
    state.flags = is_engaged_ ? OOS_DEVICE_IS_ENGAGED : 0;
    state.device_time_ns = now_ns;
    state.X_BD[0] = 1.0;
    for (int i = 0; i < 3; ++i) {
      state.V_BD[i] = V_BD_.angular_rad_per_s[i];
      state.V_BD[3 + i] = V_BD_.linear_m_per_s[i];
    }
    return device::EncodeState({device::FrameKind::kState, ++sequence_, 0, now_ns}, state);
  }
  static device::Frame Description() {
    oos_device_description d{};
    std::strcpy(d.name, "peer");
    std::strcpy(d.serial, "7");
    d.flags = OOS_DEVICE_TELLS_VELOCITY;
    d.sensed = d.actuated = OOS_DEVICE_TRANSLATION | OOS_DEVICE_ROTATION | OOS_DEVICE_GRIP;
    return device::EncodeDescription({device::FrameKind::kDescription, 1, 0, 1}, d);
  }

  ToldCommand told_;
  std::uint64_t num_told_ = 0;

 private:
  core::Twist V_BD_;
  bool is_engaged_ = true;
  std::uint32_t sequence_ = 0;
};

class UdpPeer final : public WirePeer {
 public:
  UdpPeer() : port_(device::FreeUdpPort()) { Plug(); }
  void Name(scene::Device* device) const override {
    device->type = "udp";
    device->address = std::to_string(port_);
  }
  void Plug() override { device_ = std::make_unique<device::FakeUdpDevice>(port_); }
  void Unplug() override {
    device_.reset();
    Forget();
  }
  void Serve(std::int64_t now_ns) override {
    if (device_ == nullptr) return;
    device::ReadFrame frame;
    while (device_->Receive(&frame)) {
      Take(frame.command);
      if ((frame.command_flags & device::kDescribeYourself) != 0) device_->Send(Description());
    }
    device_->Send(State(now_ns));
  }

 private:
  std::uint16_t port_;
  std::unique_ptr<device::FakeUdpDevice> device_;
};

// Its path is a link to the line, as those of /dev/serial/by-id are.
class SerialPeer final : public WirePeer {
 public:
  SerialPeer() : path_(::testing::TempDir() + "device_bridge_line_" + std::to_string(getpid())) { Plug(); }
  ~SerialPeer() override { Unplug(); }
  void Name(scene::Device* device) const override {
    device->type = "serial";
    device->address = path_;
  }
  void Plug() override {
    line_ = std::make_unique<device::FakeSerialDevice>();
    ASSERT_TRUE(line_->Plug());
    std::filesystem::remove(path_);
    std::filesystem::create_symlink(line_->path(), path_);
    // Who also has the other end open can tell when bytes have arrived; raw, or they arrive at the end of a line.
    watch_ = open(path_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
    termios settings{};
    ASSERT_EQ(tcgetattr(watch_, &settings), 0);
    cfmakeraw(&settings);
    ASSERT_EQ(tcsetattr(watch_, TCSANOW, &settings), 0);
  }
  void Unplug() override {
    if (watch_ >= 0) close(watch_);
    watch_ = -1;
    line_.reset();
    std::filesystem::remove(path_);
    Forget();
  }
  void Serve(std::int64_t now_ns) override {
    if (line_ == nullptr) return;
    device::ReadFrame frame;
    while (line_->Receive(&frame)) {
      Take(frame.command);
      if ((frame.command_flags & device::kDescribeYourself) != 0) line_->Send(Description());
    }
    line_->Send(State(now_ns));
    pollfd wait{watch_, POLLIN, 0};
    poll(&wait, 1, 1000);
  }

 private:
  std::string path_;
  std::unique_ptr<device::FakeSerialDevice> line_;
  int watch_ = -1;
};

// Force alone: Haply's service has no torque, no grip and no brake.
class HaplyPeer final : public WirePeer {
 public:
  void Name(scene::Device* device) const override {
    device->type = "haply";
    device->address = service_.address();
  }
  void Plug() override { EXPECT_TRUE(service_.Start()); }
  void Unplug() override { service_.Stop(); }
  void Serve(std::int64_t /*now_ns*/) override {
    service_.Serve();
    if (service_.force().empty()) return;
    const auto message = nlohmann::json::parse(service_.force());
    const auto& force = message["inverse3"][0]["commands"]["set_cursor_force"]["values"];
    oos_device_command command{};
    for (int i = 0; i < 3; ++i) command.F_Do_B[i] = force[std::string(1, "xyz"[i])].get<double>();
    Take(command);
  }

 private:
  device::FakeHaplyService service_;
};

}  // namespace device_bridge
