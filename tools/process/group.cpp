#include "tools/process/group.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>

#include "core/clock.hpp"

extern char** environ;

namespace process {
namespace {

void SleepMilliseconds(long milliseconds) {
  const timespec pause{0, milliseconds * 1'000'000L};
  nanosleep(&pause, nullptr);
}

}  // namespace

std::string Exit::Describe() const {
  if (signal != 0) return "killed by signal " + std::to_string(signal) + " (" + strsignal(signal) + ")";
  return "exit status " + std::to_string(status);
}

core::Result<pid_t> Group::Spawn(const Command& command) {
  // Everything that allocates happens before fork: between fork and exec only async-signal-safe calls are allowed.
  std::vector<std::string> words = {command.program.string()};
  words.insert(words.end(), command.arguments.begin(), command.arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  std::vector<std::string> variables;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string text = *variable;
    if (command.environment.count(text.substr(0, text.find('='))) == 0) variables.push_back(text);
  }
  for (const auto& [name, value] : command.environment) variables.push_back(name + "=" + value);
  std::vector<char*> envp;
  for (std::string& variable : variables) envp.push_back(variable.data());
  envp.push_back(nullptr);

  const std::string log = command.log.empty() ? "/dev/null" : command.log.string();
  const int log_fd = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (log_fd < 0) {
    return core::Fail(core::ErrorCode::kIo, "cannot write the log " + log + ": " + std::strerror(errno));
  }
  // The child tells through this pipe that exec failed; a successful exec closes it.
  int failure[2];
  if (pipe2(failure, O_CLOEXEC) != 0) {
    close(log_fd);
    return core::Fail(core::ErrorCode::kResource, std::string("cannot open a pipe: ") + std::strerror(errno));
  }
  const pid_t parent = getpid();
  const pid_t group = group_;
  const pid_t pid = fork();
  if (pid == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(127);  // the parent died before prctl took effect
    setpgid(0, group);
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, nullptr);
    signal(SIGINT, SIG_DFL);
    signal(SIGTERM, SIG_DFL);
    const int null_fd = open("/dev/null", O_RDONLY);
    dup2(null_fd, STDIN_FILENO);
    dup2(log_fd, STDOUT_FILENO);
    dup2(log_fd, STDERR_FILENO);
    if (command.inherited_fd >= 0) fcntl(command.inherited_fd, F_SETFD, 0);
    if (command.nice != 0) {
      errno = 0;
      if (nice(command.nice) == -1 && errno != 0) {
        // Not being nice is no reason to fail: the kernel only refuses to raise the priority.
      }
    }
    execve(argv[0], argv.data(), envp.data());
    const int error = errno;
    if (write(failure[1], &error, sizeof error) < 0) _exit(126);
    _exit(127);
  }
  close(log_fd);
  close(failure[1]);
  if (pid < 0) {
    close(failure[0]);
    return core::Fail(core::ErrorCode::kResource, "cannot fork for " + command.name + ": " + std::strerror(errno));
  }
  int error = 0;
  ssize_t got = 0;
  do {
    got = read(failure[0], &error, sizeof error);
  } while (got < 0 && errno == EINTR);
  close(failure[0]);
  if (got == sizeof error) {
    waitpid(pid, nullptr, 0);
    return core::Fail(core::ErrorCode::kNotFound, "cannot start " + command.name + " (" + command.program.string() +
                                                      "): " + std::strerror(error) + "; build it first");
  }
  if (group_ == 0) group_ = pid;
  setpgid(pid, group_);  // also done by the child: whoever comes first
  children_.push_back({command.name, pid, std::nullopt});
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

std::vector<std::string> Group::StopAll(double patience_s, const std::vector<std::string>& names) {
  const auto is_meant = [&](const Child& child) {
    return !child.exit && (names.empty() || std::find(names.begin(), names.end(), child.name) != names.end());
  };
  const auto any_left = [&] {
    Reap();
    return std::any_of(children_.begin(), children_.end(), is_meant);
  };
  if (any_left()) {
    for (const Child& child : children_) {
      if (is_meant(child)) kill(child.pid, SIGTERM);
    }
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
