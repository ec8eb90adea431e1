#pragma once

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>

#include "device/sha1.hpp"
#include "device/websocket.hpp"

namespace device {

inline constexpr const char* kHaplyMessage = R"({"inverse3": [{"device_id": "04A5", "state":
  {"cursor_position": {"x": 0.01, "y": -0.12, "z": 0.2}, "cursor_velocity": {"x": 0, "y": 0.5, "z": 0}}}],
  "wireless_verse_grip": [{"device_id": "61576", "state":
  {"orientation": {"w": 0.7071, "x": 0.7071, "y": 0, "z": 0}, "buttons": {"a": true, "b": false, "c": true}}}]})";

// What a server answers to a WebSocket that opens.
inline std::string HaplyOpening(const std::string& accept) {
  return "HTTP/1.1 101 Switching Protocols\r\nupgrade: WebSocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: " +
         accept + "\r\n\r\n";
}

// A server that speaks the service's protocol: it answers each force with the next state.
class FakeHaplyService {
 public:
  FakeHaplyService() { Start(); }
  ~FakeHaplyService() { Stop(); }
  FakeHaplyService(const FakeHaplyService&) = delete;
  FakeHaplyService& operator=(const FakeHaplyService&) = delete;

  [[nodiscard]] std::string address() const { return "127.0.0.1:" + std::to_string(port_); }
  [[nodiscard]] const std::string& force() const { return force_; }
  // Listens, at the port that it had before if there was one. False: the port is taken.
  bool Start() {
    listener_ = socket(AF_INET, SOCK_STREAM, 0);
    const int yes = 1;
    setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port_);
    socklen_t size = sizeof address;
    const bool listens = bind(listener_, reinterpret_cast<const sockaddr*>(&address), size) == 0 &&
                         listen(listener_, 1) == 0 &&
                         getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) == 0;
    port_ = ntohs(address.sin_port);
    return listens;
  }
  void Stop() {
    Drop();
    if (listener_ >= 0) close(listener_);
    listener_ = -1;
  }
  void Drop() {
    if (client_ >= 0) close(client_);
    client_ = -1;
    in_.clear();
    is_open_ = false;
  }
  // Reads what has come and answers it.
  void Serve() {
    if (listener_ < 0) return;
    pollfd wait{listener_, POLLIN, 0};
    if (client_ < 0 && poll(&wait, 1, 0) > 0) client_ = accept(listener_, nullptr, nullptr);
    if (client_ < 0) return;
    char bytes[4096];
    const ssize_t size = recv(client_, bytes, sizeof bytes, MSG_DONTWAIT);
    if (size > 0) in_.append(bytes, static_cast<std::size_t>(size));
    if (!is_open_) {
      const std::size_t at = in_.find("Sec-WebSocket-Key: ");
      if (in_.find("\r\n\r\n") == std::string::npos || at == std::string::npos) return;
      const std::string key = in_.substr(at + 19, 24);
      in_.clear();
      const auto digest = Sha1(key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11");
      Send(HaplyOpening(Base64(digest.data(), digest.size())));
      is_open_ = true;
      SendState();
      return;
    }
    if (in_.size() < 8) return;
    std::size_t length = in_[1] & 0x7F, head = 2;
    if (length == 126) {
      length = static_cast<std::uint8_t>(in_[2]) * 256U + static_cast<std::uint8_t>(in_[3]);
      head = 4;
    }
    if (in_.size() < head + 4 + length) return;
    force_.clear();
    for (std::size_t i = 0; i < length; ++i) force_ += static_cast<char>(in_[head + 4 + i] ^ in_[head + i % 4]);
    in_.erase(0, head + 4 + length);
    SendState();
  }

 private:
  void SendState() {
    const std::string text = kHaplyMessage;
    std::string frame = "\x81";
    frame += static_cast<char>(126);
    frame += static_cast<char>(text.size() >> 8);
    frame += static_cast<char>(text.size() & 255);
    Send(frame + text);
  }
  void Send(const std::string& bytes) const { send(client_, bytes.data(), bytes.size(), MSG_NOSIGNAL); }

  int listener_ = -1;
  int client_ = -1;
  std::uint16_t port_ = 0;
  std::string in_, force_;
  bool is_open_ = false;
};

}  // namespace device
