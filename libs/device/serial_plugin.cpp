#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <span>
#include <string>

#include "device/builtin.hpp"
#include "device/cobs.hpp"
#include "device/link_plugin.hpp"
#include "device/say_why.hpp"

namespace device {
namespace {

// A state of 214 bytes on the line at 1 kHz needs 2.2 Mbit/s: what USB serial adapters reach, and USB devices ignore.
constexpr speed_t kDefaultSpeed = B3000000;
// Bytes that one step takes: some twenty frames.
constexpr int kMaxReads = 16;

struct Speed {
  const char* text;
  speed_t speed;
};
constexpr Speed kSpeeds[] = {{"115200", B115200},   {"230400", B230400},   {"460800", B460800},
                             {"921600", B921600},   {"1000000", B1000000}, {"2000000", B2000000},
                             {"3000000", B3000000}, {"4000000", B4000000}};

class SerialDevice {
 public:
  explicit SerialDevice(int fd) : fd_(fd) {}
  ~SerialDevice() { close(fd_); }
  SerialDevice(const SerialDevice&) = delete;
  SerialDevice& operator=(const SerialDevice&) = delete;

  [[nodiscard]] int fd() const { return fd_; }
  [[nodiscard]] const FrameLink& link() const { return link_; }

  int Step(std::int64_t now_ns, const oos_device_command* command, oos_device_state* state) {
    const bool is_there = Receive(now_ns);
    if (is_there && command != nullptr && !Send(link_.Command(*command, now_ns))) return OOS_DEVICE_GONE;
    *state = link_.state();
    return is_there ? OOS_DEVICE_OK : OOS_DEVICE_GONE;
  }

 private:
  // False: unplugged.
  bool Receive(std::int64_t now_ns) {
    for (int i = 0; i < kMaxReads; ++i) {
      std::uint8_t bytes[kMaxFrameSize];
      const ssize_t size = read(fd_, bytes, sizeof bytes);
      if (size < 0) return errno == EAGAIN || errno == EINTR;
      if (size == 0) return !IsHungUp();  // VMIN 0: nothing there; or the other end of a pseudo-terminal has gone
      for (ssize_t k = 0; k < size; ++k) {
        if (unstuffer_.Take(bytes[k])) link_.Take(unstuffer_.bytes(), now_ns);
      }
    }
    return true;
  }
  [[nodiscard]] bool IsHungUp() const {
    pollfd poll_fd{fd_, POLLIN, 0};
    return poll(&poll_fd, 1, 0) > 0 && (poll_fd.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0;
  }
  // When the line has room for a part of a frame only, the zero before the next one ends it.
  [[nodiscard]] bool Send(const Frame& frame) const {
    std::uint8_t stuffed[1 + kMaxStuffed] = {0};
    const std::size_t size = 1 + Stuff(frame.span(), std::span<std::uint8_t, kMaxStuffed>(stuffed + 1, kMaxStuffed));
    const ssize_t written = write(fd_, stuffed, size);
    return written >= 0 || errno == EAGAIN || errno == EINTR;
  }

  int fd_;
  FrameLink link_;
  Unstuffer unstuffer_;
};

// Raw bytes, no echo, no waiting.
bool MakeRaw(int fd, speed_t speed) {
  termios settings{};
  if (tcgetattr(fd, &settings) != 0) return false;
  cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cc[VMIN] = 0;
  settings.c_cc[VTIME] = 0;
  cfsetispeed(&settings, speed);
  cfsetospeed(&settings, speed);
  return tcsetattr(fd, TCSANOW, &settings) == 0 && tcflush(fd, TCIOFLUSH) == 0;
}

int OpenSerial(const oos_device_setting* setting, void** device) {
  std::string path = setting->address;
  speed_t speed = kDefaultSpeed;
  if (const std::size_t colon = path.rfind(':'); colon != std::string::npos) {
    const std::string wanted = path.substr(colon + 1);
    path.resize(colon);
    bool is_known = false;
    for (const Speed& known : kSpeeds) {
      if (wanted != known.text) continue;
      speed = known.speed;
      is_known = true;
    }
    if (!is_known) {
      SayWhy(*setting, "speed is '" + wanted + "'; write 115200, 230400, 460800, 921600 or 1 to 4 million");
      return OOS_DEVICE_BAD_SETTING;
    }
  }
  if (path.empty() || path.front() != '/') {
    SayWhy(*setting,
           "address is '" + path + "'; write a path, as /dev/serial/by-id/..., or with a speed after a colon");
    return OOS_DEVICE_BAD_SETTING;
  }
  const int fd = open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0 || !MakeRaw(fd, speed)) {
    const int error = errno;
    SayWhy(*setting, path + ": " + std::strerror(error) +
                         (error == EACCES ? "; join the group dialout, or add the udev rule that 'oos doctor' prints"
                                          : "; is it plugged in, and a serial line?"));
    if (fd >= 0) close(fd);
    return OOS_DEVICE_GONE;
  }
  *device = new SerialDevice(fd);
  return OOS_DEVICE_OK;
}

}  // namespace

const oos_device_plugin& SerialPlugin() {
  static const oos_device_plugin plugin = PluginOf<SerialDevice>(OpenSerial);
  return plugin;
}

}  // namespace device
