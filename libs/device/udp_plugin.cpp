#include <arpa/inet.h>
#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>
#include <optional>
#include <string>

#include "device/builtin.hpp"
#include "device/link_plugin.hpp"
#include "device/say_why.hpp"

namespace device {
namespace {

// Datagrams that one step takes: a flood must not keep it. A device of 1 kHz sends one between two steps.
constexpr int kMaxDatagrams = 64;

std::optional<sockaddr_in> ParseAddress(std::string_view text) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const std::size_t colon = text.rfind(':');
  if (colon != std::string_view::npos) {
    if (inet_pton(AF_INET, std::string(text.substr(0, colon)).c_str(), &address.sin_addr) != 1) return std::nullopt;
    text.remove_prefix(colon + 1);
  }
  std::uint16_t port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  if (error != std::errc() || end != text.data() + text.size() || port == 0) return std::nullopt;
  address.sin_port = htons(port);
  return address;
}

bool IsSame(const sockaddr_in& a, const sockaddr_in& b) {
  return a.sin_addr.s_addr == b.sin_addr.s_addr && a.sin_port == b.sin_port;
}

class UdpDevice {
 public:
  explicit UdpDevice(int socket) : socket_(socket) {}
  ~UdpDevice() { close(socket_); }
  UdpDevice(const UdpDevice&) = delete;
  UdpDevice& operator=(const UdpDevice&) = delete;

  [[nodiscard]] int fd() const { return socket_; }
  [[nodiscard]] const FrameLink& link() const { return link_; }

  int Step(std::int64_t now_ns, const oos_device_command* command, oos_device_state* state) {
    for (int i = 0; i < kMaxDatagrams && Receive(now_ns); ++i) {
    }
    if (command != nullptr && has_peer_) {
      const Frame frame = link_.Command(*command, now_ns);
      // A datagram that cannot be sent is lost, as any may be.
      static_cast<void>(sendto(socket_, frame.bytes.data(), frame.size, MSG_DONTWAIT | MSG_NOSIGNAL,
                               reinterpret_cast<const sockaddr*>(&peer_), sizeof peer_));
    }
    *state = link_.state();
    return OOS_DEVICE_OK;
  }

 private:
  // False: there is none.
  bool Receive(std::int64_t now_ns) {
    std::uint8_t bytes[kMaxFrameSize + 1];
    sockaddr_in from{};
    socklen_t from_size = sizeof from;
    const ssize_t size =
        recvfrom(socket_, bytes, sizeof bytes, MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&from), &from_size);
    if (size < 0) return errno == ECONNREFUSED;
    const bool is_peer = has_peer_ && IsSame(from, peer_);
    // Two devices at one port would move one hand: the first keeps it as long as it sends.
    if (has_peer_ && !is_peer && !link_.is_silent(now_ns)) return true;
    if (!is_peer) link_.Forget();
    if (link_.Take({bytes, static_cast<std::size_t>(size)}, now_ns)) {
      peer_ = from;
      has_peer_ = true;
    }
    return true;
  }

  int socket_;
  FrameLink link_;
  sockaddr_in peer_{};
  bool has_peer_ = false;
};

int OpenUdp(const oos_device_setting* setting, void** device) {
  const auto address = ParseAddress(setting->address);
  if (!address) {
    SayWhy(*setting, std::string("address is '") + setting->address +
                         "'; write a port, as 7460, or an IPv4 address of this machine and a port, as 10.0.0.5:7460");
    return OOS_DEVICE_BAD_SETTING;
  }
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd < 0 || bind(fd, reinterpret_cast<const sockaddr*>(&*address), sizeof *address) != 0) {
    SayWhy(*setting, std::string(setting->address) + ": " + std::strerror(errno) +
                         "; does another program listen there, or is the address another machine's?");
    if (fd >= 0) close(fd);
    return OOS_DEVICE_GONE;
  }
  *device = new UdpDevice(fd);
  return OOS_DEVICE_OK;
}

}  // namespace

const oos_device_plugin& UdpPlugin() {
  static const oos_device_plugin plugin = PluginOf<UdpDevice>(OpenUdp);
  return plugin;
}

}  // namespace device
