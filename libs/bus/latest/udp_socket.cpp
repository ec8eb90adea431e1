#include "bus/latest/udp_socket.hpp"

#include <arpa/inet.h>
#include <netinet/ip.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <system_error>
#include <utility>

namespace bus::detail {

namespace {

auto Fail(const std::string& what, const std::string& advice) {
  return core::Fail(core::ErrorCode::kIo,
                    what + " failed: " + std::error_code(errno, std::generic_category()).message() + "; " + advice);
}

}  // namespace

core::Result<UdpSocket> UdpSocket::Bind(const std::string& address) {
  sockaddr_in bound{};
  if (!ParseEndpoint(address + ":0", &bound)) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "bind address '" + address + "' is not an IPv4 address; use e.g. 127.0.0.1");
  }
  UdpSocket udp;
  udp.fd_ = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const auto fail = [&](const char* what) {
    return Fail(std::string(what) + " of a UDP socket on " + address, "is it an address of this host?");
  };
  if (udp.fd_ < 0) return fail("opening");
  setsockopt(udp.fd_, SOL_SOCKET, SO_RCVBUF, &kUdpBufferBytes, sizeof(kUdpBufferBytes));
  setsockopt(udp.fd_, SOL_SOCKET, SO_SNDBUF, &kUdpBufferBytes, sizeof(kUdpBufferBytes));
  constexpr int kExpeditedForwarding = 46 << 2;  // DSCP EF: priority for force data where the network honours it
  setsockopt(udp.fd_, IPPROTO_IP, IP_TOS, &kExpeditedForwarding, sizeof(kExpeditedForwarding));
  if (bind(udp.fd_, reinterpret_cast<const sockaddr*>(&bound), sizeof(bound)) != 0) return fail("binding");
  socklen_t size = sizeof(bound);
  if (getsockname(udp.fd_, reinterpret_cast<sockaddr*>(&bound), &size) != 0) return fail("naming");
  udp.endpoint_ = address + ":" + std::to_string(ntohs(bound.sin_port));
  return udp;
}

core::Result<UdpSocket> UdpSocket::Join(const std::string& group, const std::string& address) {
  sockaddr_in bound{};
  ip_mreq membership{};
  if (!ParseEndpoint(group, &bound) || !IN_MULTICAST(ntohl(bound.sin_addr.s_addr)) || bound.sin_port == 0 ||
      inet_pton(AF_INET, address.c_str(), &membership.imr_interface) != 1) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "multicast group '" + group + "' is not of the form 239.255.74.50:7450");
  }
  membership.imr_multiaddr = bound.sin_addr;
  UdpSocket udp;
  udp.fd_ = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  udp.endpoint_ = group;
  constexpr int kYes = 1;  // every node of a machine binds the same port
  setsockopt(udp.fd_, SOL_SOCKET, SO_REUSEADDR, &kYes, sizeof(kYes));
  setsockopt(udp.fd_, SOL_SOCKET, SO_RCVBUF, &kUdpBufferBytes, sizeof(kUdpBufferBytes));
  if (bind(udp.fd_, reinterpret_cast<const sockaddr*>(&bound), sizeof(bound)) != 0 ||
      setsockopt(udp.fd_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof(membership)) != 0) {
    return Fail("joining the multicast group " + group + " on " + address, "does its interface carry multicast?");
  }
  return udp;
}

core::Result<void> UdpSocket::SendToGroupsBy(const std::string& address) {
  in_addr interface {};
  if (inet_pton(AF_INET, address.c_str(), &interface) != 1 ||
      setsockopt(fd_, IPPROTO_IP, IP_MULTICAST_IF, &interface, sizeof(interface)) != 0) {
    return Fail("sending to multicast groups by " + address, "does its interface carry multicast?");
  }
  return {};
}

UdpSocket::UdpSocket(UdpSocket&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), endpoint_(std::move(other.endpoint_)) {}

UdpSocket& UdpSocket::operator=(UdpSocket&& other) noexcept {
  if (this != &other) {
    if (fd_ >= 0) close(fd_);
    fd_ = std::exchange(other.fd_, -1);
    endpoint_ = std::move(other.endpoint_);
  }
  return *this;
}

UdpSocket::~UdpSocket() {
  if (fd_ >= 0) close(fd_);
}

bool UdpSocket::Send(const sockaddr_in& to, const std::uint8_t* data, std::size_t size) const noexcept {
  return sendto(fd_, data, size, MSG_DONTWAIT | MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&to), sizeof(to)) ==
         static_cast<ssize_t>(size);
}

bool ParseEndpoint(const std::string& endpoint, sockaddr_in* address) {
  const std::size_t colon = endpoint.rfind(':');
  if (colon == std::string::npos) return false;
  unsigned port = 0;
  const char* const end = endpoint.data() + endpoint.size();
  const auto [rest, error] = std::from_chars(endpoint.data() + colon + 1, end, port);
  if (error != std::errc() || rest != end || port > 0xffff) return false;
  *address = {};
  address->sin_family = AF_INET;
  address->sin_port = htons(static_cast<std::uint16_t>(port));
  return inet_pton(AF_INET, endpoint.substr(0, colon).c_str(), &address->sin_addr) == 1;
}

}  // namespace bus::detail
