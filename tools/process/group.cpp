#include "tools/process/group.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>

#include "core/clock.hpp"

namespace process {
namespace {

void SleepMilliseconds(long milliseconds) {
  const timespec pause{0, milliseconds * 1'000'000L};
  nanosleep(&pause, nullptr);
}

// No names: all.
bool IsMeant(const Group::Child& child, const std::vector<std::string>& names) {
  return !child.exit && (names.empty() || std::find(names.begin(), names.end(), child.name) != names.end());
}

}  // namespace

core::Result<pid_t> Group::Spawn(const Command& command) {
  const std::string log = command.log.empty() ? "/dev/null" : command.log.string();
  const int log_fd = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (log_fd < 0) {
    return core::Fail(core::ErrorCode::kIo, "cannot write the log " + log + ": " + std::strerror(errno));
  }
  const int null_fd = open("/dev/null", O_RDONLY | O_CLOEXEC);
  Bond bond;
  bond.in_fd = null_fd;
  bond.out_fd = bond.err_fd = log_fd;
  bond.group = group_ == 0 ? Bond::Group::kOwn : Bond::Group::kGiven;
  bond.given_group = group_;
  auto pid = process::Spawn(command, bond);
  close(log_fd);
  close(null_fd);
  if (!pid) return pid;
  if (group_ == 0) group_ = *pid;
  setpgid(*pid, group_);  // also done by the child: whoever comes first
  children_.push_back({command.name, *pid, std::nullopt});
  return pid;
}

std::vector<std::size_t> Group::Reap() {
  std::vector<std::size_t> ended;
  for (std::size_t i = 0; i < children_.size(); ++i) {
    Child& child = children_[i];
    if (child.exit) continue;
    int status = 0;
    if (waitpid(child.pid, &status, WNOHANG) != child.pid) continue;
    Exit exit;
    if (WIFSIGNALED(status)) {
      exit.signal = WTERMSIG(status);
    } else {
      exit.status = WEXITSTATUS(status);
    }
    child.exit = exit;
    ended.push_back(i);
  }
  return ended;
}

bool Group::IsRunning(const std::string& name) const {
  return std::any_of(children_.begin(), children_.end(), [&](const Child& c) { return c.name == name && !c.exit; });
}

void Group::Terminate(const std::vector<std::string>& names) {
  Reap();  // what has ended gets no signal: another process may have its number
  for (const Child& child : children_) {
    if (IsMeant(child, names)) kill(child.pid, SIGTERM);
  }
}

std::vector<std::string> Group::StopAll(double patience_s, const std::vector<std::string>& names) {
  const auto is_meant = [&](const Child& child) { return IsMeant(child, names); };
  const auto any_left = [&] {
    Reap();
    return std::any_of(children_.begin(), children_.end(), is_meant);
  };
  if (any_left()) {
    Terminate(names);
    const std::int64_t deadline = core::MonotonicNow_ns() + static_cast<std::int64_t>(patience_s * 1e9);
    while (any_left() && core::MonotonicNow_ns() < deadline) SleepMilliseconds(5);
  }
  std::vector<std::string> killed;
  for (const Child& child : children_) {
    if (!is_meant(child)) continue;
    killed.push_back(child.name);
    kill(child.pid, SIGKILL);
  }
  // Grandchildren share the group.
  if (names.empty() && group_ > 0) {
    kill(-group_, SIGKILL);
    group_ = 0;
  }
  while (any_left()) SleepMilliseconds(1);
  return killed;
}

}  // namespace process
