#pragma once

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <unistd.h>

#include <span>
#include <string>

#include "device/cobs.hpp"
#include "device/frame.hpp"

namespace device {

// A device at the other end of a pseudo-terminal.
class FakeSerialDevice {
 public:
  FakeSerialDevice() = default;
  ~FakeSerialDevice() { Unplug(); }
  FakeSerialDevice(const FakeSerialDevice&) = delete;
  FakeSerialDevice& operator=(const FakeSerialDevice&) = delete;

  // A new line, whose path may be another. False: the machine has none.
  bool Plug() {
    line_ = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
    return line_ >= 0 && grantpt(line_) == 0 && unlockpt(line_) == 0;
  }
  void Unplug() {
    if (line_ >= 0) close(line_);
    line_ = -1;
  }
  [[nodiscard]] std::string path() const { return ptsname(line_); }

  bool Write(std::span<const std::uint8_t> bytes) const {
    return write(line_, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size());
  }
  bool Send(const Frame& frame) const {
    std::uint8_t bytes[kMaxStuffed];
    const std::size_t size = Stuff(frame.span(), std::span<std::uint8_t, kMaxStuffed>(bytes));
    return Write({bytes, size});
  }
  bool SendState(std::uint32_t sequence) const {
    oos_device_state state{};
    state.X_BD[0] = 1.0;
    state.X_BD[4] = sequence;
    return Send(EncodeState({FrameKind::kState, sequence, 0, 1}, state));
  }
  void Wait(int ms) const {
    pollfd wait{line_, POLLIN, 0};
    poll(&wait, 1, ms);
  }
  // The next frame that has come.
  bool Receive(ReadFrame* frame) {
    std::uint8_t byte = 0;
    while (read(line_, &byte, 1) == 1) {
      if (unstuffer_.Take(byte) && DecodeFrame(unstuffer_.bytes(), frame) == FrameFault::kNone) return true;
    }
    return false;
  }

 private:
  int line_ = -1;
  Unstuffer unstuffer_;
};

}  // namespace device
