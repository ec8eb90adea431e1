#include "nodes/device_bridge/head/dtrack_head.hpp"

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
#include "tracking/dtrack.hpp"
#include "tracking/listen.hpp"

namespace device_bridge {
namespace {

constexpr std::size_t kMostBytes = 65536;  // of a datagram

}  // namespace

core::Result<std::unique_ptr<DtrackHead>> DtrackHead::Create(const scene::User& user) {
  const std::string who =
      user.location.file.empty()
          ? "user '" + user.name + "': "
          : user.location.file.string() + ":" + std::to_string(user.location.line) + ": user '" + user.name + "': ";
  const auto listener = tracking::Listen(user.address);
  if (!listener) return core::Fail(listener.error().code, who + listener.error().detail);
  const int wake_fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  if (wake_fd < 0) {
    const std::string why = std::strerror(errno);
    close(listener->fd);
    return core::Fail(core::ErrorCode::kIo, who + "no thread can listen for it: " + why);
  }
  return std::unique_ptr<DtrackHead>(new DtrackHead(user, listener->fd, wake_fd, listener->port));
}

DtrackHead::DtrackHead(const scene::User& user, int socket, int wake_fd, std::uint16_t port)
    : socket_(socket),
      wake_fd_(wake_fd),
      port_(port),
      body_(user.body),
      X_RT_(user.X_RT),
      X_BH_(user.X_BH),
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
  return X_RT_ * poses_TB_.value() * X_BH_;
}

}  // namespace device_bridge
