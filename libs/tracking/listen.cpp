#include "tracking/listen.hpp"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "scene/udp_address.hpp"

namespace tracking {
namespace {

bool BindAndJoin(int fd, sockaddr_in* address) {
  const int yes = 1;
  const bool is_group = IN_MULTICAST(ntohl(address->sin_addr.s_addr));
  if (is_group) setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  if (bind(fd, reinterpret_cast<const sockaddr*>(address), sizeof *address) != 0) return false;
  if (is_group) {
    const ip_mreq group{address->sin_addr, {htonl(INADDR_ANY)}};
    if (setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &group, sizeof group) != 0) return false;
  }
  socklen_t size = sizeof *address;
  return getsockname(fd, reinterpret_cast<sockaddr*>(address), &size) == 0;
}

}  // namespace

core::Result<Listener> Listen(const std::string& address) {
  const auto parsed = scene::ParseUdpAddress(address);
  if (!parsed) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "address is '" + address +
                          "'; write the port that DTrack sends to, as 5000, or a multicast group and a port, as "
                          "239.0.1.1:5000");
  }
  sockaddr_in there{};
  there.sin_family = AF_INET;
  there.sin_addr.s_addr = htonl(parsed->ip);
  there.sin_port = htons(parsed->port);
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd < 0 || !BindAndJoin(fd, &there)) {
    const std::string why = std::strerror(errno);
    if (fd >= 0) close(fd);
    return core::Fail(core::ErrorCode::kIo, "nothing can be received at " + address + ": " + why +
                                                "; does another program listen there, or is the address another "
                                                "machine's?");
  }
  return Listener{fd, ntohs(there.sin_port)};
}

}  // namespace tracking
