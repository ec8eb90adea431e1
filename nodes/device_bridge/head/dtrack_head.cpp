#include "nodes/device_bridge/head/dtrack_head.hpp"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <vector>

#include "bus/rt/thread_setup.hpp"
#include "scene/udp_address.hpp"
#include "tracking/dtrack.hpp"

namespace device_bridge {
namespace {

constexpr std::size_t kMostBytes = 65536;  // of a datagram

std::optional<sockaddr_in> AddressOf(const std::string& text) {
  const auto parsed = scene::ParseUdpAddress(text);
  if (!parsed) return std::nullopt;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(parsed->ip);
  address.sin_port = htons(parsed->port);
  return address;
}

bool Listen(int fd, sockaddr_in* address) {
  const int yes = 1;
  // Several programs may hear a group.
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

core::Result<std::unique_ptr<DtrackHead>> DtrackHead::Create(const scene::User& user) {
  const std::string who =
      user.location.file.empty()
          ? "user '" + user.name + "': "
          : user.location.file.string() + ":" + std::to_string(user.location.line) + ": user '" + user.name + "': ";
  auto address = AddressOf(user.address);
  if (!address) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      who + "address is '" + user.address +
                          "'; write the port that DTrack sends to, as 5000, or a multicast group and a port, as "
                          "239.0.1.1:5000");
  }
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const int wake_fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  if (fd < 0 || wake_fd < 0 || !Listen(fd, &*address)) {
    const std::string why = std::strerror(errno);
    if (fd >= 0) close(fd);
    if (wake_fd >= 0) close(wake_fd);
    return core::Fail(core::ErrorCode::kIo, who + "nothing can be received at " + user.address + ": " + why +
                                                "; does another program listen there, or is the address another "
                                                "machine's?");
  }
  return std::unique_ptr<DtrackHead>(new DtrackHead(user, fd, wake_fd, ntohs(address->sin_port)));
}

DtrackHead::DtrackHead(const scene::User& user, int socket, int wake_fd, std::uint16_t port)
    : socket_(socket),
      wake_fd_(wake_fd),
      port_(port),
      body_(user.body),
      X_RT_(user.X_RT),
      p_BH_m_(user.p_BH_m),
      description_("body " + std::to_string(user.body) + " of DTrack, at UDP port " + std::to_string(port)),
      thread_([this] { Run(); }) {}

DtrackHead::~DtrackHead() {
  is_stop_wanted_.store(true);
  const std::uint64_t one = 1;
  static_cast<void>(!write(wake_fd_, &one, sizeof one));
  thread_.join();
  close(wake_fd_);
  close(socket_);
}

void DtrackHead::Run() {
  bus::ThreadSetup setup;
  setup.name = "dtrack";
  setup.locks_memory = false;
  bus::SetUpThread(setup);
  std::vector<char> bytes(kMostBytes);
  while (!is_stop_wanted_.load()) {
    std::array<pollfd, 2> fds = {pollfd{socket_, POLLIN, 0}, pollfd{wake_fd_, POLLIN, 0}};
    if (poll(fds.data(), fds.size(), -1) <= 0) continue;
    const ssize_t size = recv(socket_, bytes.data(), bytes.size(), 0);
    if (size <= 0) continue;
    Take({bytes.data(), static_cast<std::size_t>(size)});
    num_read_.fetch_add(1);
  }
}

void DtrackHead::Take(std::string_view datagram) {
  std::vector<std::string> complaints;
  const tracking::DtrackFrame frame = tracking::ParseDtrack(datagram, &complaints);
  // Once: a tracker sends sixty a second.
  if (!complaints.empty() && num_bad_++ == 0) {
    std::printf("%s: %s; further ones are not shown\n", description_.c_str(), complaints.front().c_str());
    std::fflush(stdout);
  }
  for (const tracking::TrackedBody& body : frame.bodies) {
    if (body.id == body_ && body.is_tracked()) poses_TB_.Write(body.X_TB);
  }
}

std::optional<core::Pose> DtrackHead::Read(std::int64_t /*now_ns*/) noexcept {
  if (!poses_TB_.Update()) return std::nullopt;
  core::Pose X_RH = X_RT_ * poses_TB_.value();
  X_RH.translation += X_RH.rotate(p_BH_m_);
  return X_RH;
}

}  // namespace device_bridge
