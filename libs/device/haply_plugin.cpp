#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <string>

#include "device/builtin.hpp"
#include "device/haply_messages.hpp"
#include "device/say_why.hpp"
#include "device/sha1.hpp"
#include "device/websocket.hpp"

namespace device {
namespace {

constexpr int kConnect_ms = 200;                   // a service of this machine answers at once
constexpr std::int64_t kAskAgain_ns = 20'000'000;  // when an answer did not come, a force asks for the next one
constexpr std::int64_t kForceAge_ns = 60'000'000;  // an older force is none
// Assumed, until somebody measures it on a device: below what its makers give as its peak.
constexpr double kMaxForce_N = 7.0;

class HaplyDevice {
 public:
  HaplyDevice(int fd, WebSocket socket) : fd_(fd), socket_(std::move(socket)) {}
  ~HaplyDevice() { close(fd_); }
  HaplyDevice(const HaplyDevice&) = delete;
  HaplyDevice& operator=(const HaplyDevice&) = delete;

  [[nodiscard]] int fd() const { return fd_; }

  int Step(std::int64_t now_ns, const oos_device_command* command, oos_device_state* state) {
    if (command != nullptr) {
      for (int i = 0; i < 3; ++i) force_N_[i] = command->F_Do_B[i];
      commanded_ns_ = now_ns;
      command_ = command->sequence;
    }
    if (now_ns - commanded_ns_ > kForceAge_ns) force_N_[0] = force_N_[1] = force_N_[2] = 0.0;
    if (!Receive()) return OOS_DEVICE_GONE;
    while (const auto text = socket_.NextText()) TakeMessage(*text, now_ns);
    if (!heard_.device_id.empty() && (is_asked_ || now_ns - sent_ns_ > kAskAgain_ns)) {
      socket_.SendText(WriteHaplyForce(heard_.device_id, force_N_));
      sent_command_ = command_;
      sent_ns_ = now_ns;
      is_asked_ = false;
    }
    if (socket_.is_broken() || !Flush()) return OOS_DEVICE_GONE;
    *state = state_;
    return OOS_DEVICE_OK;
  }

  int Describe(oos_device_description* description) const {
    if (state_.sequence == 0) return OOS_DEVICE_GONE;
    std::strncpy(description->name, "Haply Inverse3", sizeof description->name - 1);
    std::strncpy(description->serial, heard_.device_id.c_str(), sizeof description->serial - 1);
    description->flags = OOS_DEVICE_TELLS_VELOCITY;
    description->sensed = OOS_DEVICE_TRANSLATION | (heard_.has_grip ? OOS_DEVICE_ROTATION : 0);
    description->actuated = OOS_DEVICE_TRANSLATION;
    description->max_force_N = kMaxForce_N;
    return OOS_DEVICE_OK;
  }

 private:
  bool Receive() {
    char bytes[4096];
    for (int i = 0; i < 16; ++i) {
      const ssize_t size = recv(fd_, bytes, sizeof bytes, MSG_DONTWAIT);
      if (size == 0) return false;
      if (size < 0) return errno == EAGAIN || errno == EINTR;
      socket_.Take({bytes, static_cast<std::size_t>(size)});
    }
    return true;
  }
  bool Flush() {
    out_ += socket_.TakeOutput();
    while (!out_.empty()) {
      const ssize_t size = send(fd_, out_.data(), out_.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
      if (size < 0) return errno == EAGAIN || errno == EINTR;
      out_.erase(0, static_cast<std::size_t>(size));
    }
    return true;
  }
  void TakeMessage(const std::string& text, std::int64_t now_ns) {
    HaplyState heard;
    if (!ReadHaplyState(text, &heard)) return;
    heard_ = heard;
    is_asked_ = true;
    // With a grip, its first button is the dead-man.
    const bool is_engaged = !heard.has_grip || (heard.buttons & 1U) != 0;
    state_.flags = is_engaged ? OOS_DEVICE_IS_ENGAGED : 0;
    ++state_.sequence;
    state_.reflected = sent_command_;
    state_.device_time_ns = now_ns;
    for (int i = 0; i < 4; ++i) state_.X_BD[i] = heard.quaternion[i];
    for (int i = 0; i < 3; ++i) {
      state_.X_BD[4 + i] = heard.position_m[i];
      state_.V_BD[3 + i] = heard.velocity_m_per_s[i];
    }
    state_.buttons = heard.buttons;
  }

  int fd_;
  WebSocket socket_;
  std::string out_;
  HaplyState heard_;
  oos_device_state state_{};
  double force_N_[3] = {};
  std::int64_t commanded_ns_ = 0;
  std::int64_t sent_ns_ = 0;
  std::uint64_t command_ = 0, sent_command_ = 0;
  bool is_asked_ = false;
};

// -1: nobody answers there.
int Connect(const sockaddr_in& address) {
  const int fd = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd < 0) return -1;
  const int yes = 1;
  setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  int error = connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 ? 0 : errno;
  if (error == EINPROGRESS) {
    pollfd wait{fd, POLLOUT, 0};
    socklen_t size = sizeof error;
    if (poll(&wait, 1, kConnect_ms) <= 0 || getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size) != 0) error = ETIMEDOUT;
  }
  if (error == 0) return fd;
  close(fd);
  errno = error;
  return -1;
}

int OpenHaply(const oos_device_setting* setting, void** device) {
  const std::string text = setting->address;
  const std::size_t colon = std::min(text.find(':'), text.size());
  sockaddr_in address{};
  address.sin_family = AF_INET;
  std::uint16_t port = 0;
  const char* const end = text.data() + text.size();
  const char* const digits = text.data() + std::min(colon + 1, text.size());
  const bool is_port = std::from_chars(digits, end, port).ptr == end && port != 0;
  if (!is_port || inet_pton(AF_INET, text.substr(0, colon).c_str(), &address.sin_addr) != 1) {
    SayWhy(*setting, "address is '" + text + "'; write the service's IPv4 address and port, as 127.0.0.1:10001");
    return OOS_DEVICE_BAD_SETTING;
  }
  address.sin_port = htons(port);
  const int fd = Connect(address);
  if (fd < 0) {
    SayWhy(*setting, text + ": " + std::strerror(errno) + "; does Haply's Inverse Service run there?");
    return OOS_DEVICE_GONE;
  }
  std::uint8_t random[20] = {};
  static_cast<void>(!getrandom(random, sizeof random, 0));
  std::uint32_t mask = 0;
  std::memcpy(&mask, random + 16, sizeof mask);
  *device = new HaplyDevice(fd, WebSocket(text, "/", Base64(random, 16), mask));
  return OOS_DEVICE_OK;
}

}  // namespace

const oos_device_plugin& HaplyPlugin() {
  static const oos_device_plugin plugin{
      OOS_DEVICE_ABI_VERSION,
      sizeof plugin,
      OpenHaply,
      [](void* device, oos_device_description* d) -> int { return static_cast<HaplyDevice*>(device)->Describe(d); },
      [](void* device, std::int64_t now_ns, const oos_device_command* command, const oos_device_hand* /*hand*/,
         oos_device_state* state) -> int { return static_cast<HaplyDevice*>(device)->Step(now_ns, command, state); },
      [](void* device) { delete static_cast<HaplyDevice*>(device); },
      [](void* device) -> int { return static_cast<HaplyDevice*>(device)->fd(); },
      nullptr,
      nullptr};
  return plugin;
}

}  // namespace device
