#pragma once

#include <netinet/in.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "core/result.hpp"

namespace bus::detail {

// About 800 datagrams: must hold the bursts of several haptic cycles while the receiver is held up for milliseconds.
constexpr int kUdpBufferBytes = 1 << 20;

// A non-blocking UDP socket bound to a free port of one address.
class UdpSocket {
 public:
  static core::Result<UdpSocket> Bind(const std::string& address);
  // A socket that receives a multicast group, "239.255.74.50:7450", on the interface with that address.
  static core::Result<UdpSocket> Join(const std::string& group, const std::string& address);
  UdpSocket() = default;
  UdpSocket(UdpSocket&& other) noexcept;
  UdpSocket& operator=(UdpSocket&& other) noexcept;
  ~UdpSocket();

  [[nodiscard]] int fd() const { return fd_; }
  [[nodiscard]] const std::string& endpoint() const { return endpoint_; }  // "127.0.0.1:41234"
  // Sends multicast by the interface with that address, with TTL 1.
  core::Result<void> SendToGroupsBy(const std::string& address);
  // False: refused by the socket (buffer full, no route).
  bool Send(const sockaddr_in& to, const std::uint8_t* data, std::size_t size) const noexcept;

 private:
  int fd_ = -1;
  std::string endpoint_;
};

// "127.0.0.1:41234"; false when it is not of that form.
bool ParseEndpoint(const std::string& endpoint, sockaddr_in* address);

}  // namespace bus::detail
