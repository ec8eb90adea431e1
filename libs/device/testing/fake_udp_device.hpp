#pragma once

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <string>

#include "device/frame.hpp"

namespace device {

// A device at the other end of a loopback socket.
class FakeUdpDevice {
 public:
  explicit FakeUdpDevice(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    to_.sin_family = AF_INET;
    to_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to_.sin_port = htons(port);
    connect(socket_, reinterpret_cast<const sockaddr*>(&to_), sizeof to_);
  }
  ~FakeUdpDevice() { close(socket_); }
  FakeUdpDevice(const FakeUdpDevice&) = delete;
  FakeUdpDevice& operator=(const FakeUdpDevice&) = delete;

  void Send(const std::string& text) const { send(socket_, text.data(), text.size(), 0); }
  void Send(const Frame& frame) const { send(socket_, frame.bytes.data(), frame.size, 0); }
  void SendState(std::uint32_t sequence, std::uint32_t reflected = 0) const {
    oos_device_state state{};
    state.X_BD[0] = 1.0;
    state.X_BD[4] = sequence;
    Send(EncodeState({FrameKind::kState, sequence, reflected, 1}, state));
  }
  bool Receive(ReadFrame* frame) const {
    std::uint8_t bytes[300];
    const ssize_t size = recv(socket_, bytes, sizeof bytes, MSG_DONTWAIT);
    return size > 0 && DecodeFrame({bytes, static_cast<std::size_t>(size)}, frame) == FrameFault::kNone;
  }

 private:
  int socket_;
  sockaddr_in to_{};
};

// A port of the loopback interface that is free now; 0: there is none.
inline std::uint16_t FreeUdpPort() {
  const int probe = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in any{};
  any.sin_family = AF_INET;
  any.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof any;
  const bool is_bound = bind(probe, reinterpret_cast<const sockaddr*>(&any), sizeof any) == 0 &&
                        getsockname(probe, reinterpret_cast<sockaddr*>(&any), &size) == 0;
  close(probe);
  return is_bound ? ntohs(any.sin_port) : 0;
}

}  // namespace device
