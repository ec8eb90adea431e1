#include "tools/process/spawn.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

extern char** environ;

namespace process {
namespace {

// The arguments of exec. Made before fork: between fork and exec only async-signal-safe calls are allowed.
class ExecArguments {
 public:
  explicit ExecArguments(const Command& command) {
    words_.push_back(command.program.string());
    words_.insert(words_.end(), command.arguments.begin(), command.arguments.end());
    for (char** variable = environ; *variable != nullptr; ++variable) {
      const std::string text = *variable;
      if (command.environment.count(text.substr(0, text.find('='))) == 0) variables_.push_back(text);
    }
    for (const auto& [name, value] : command.environment) variables_.push_back(name + "=" + value);
    for (std::string& word : words_) argv_.push_back(word.data());
    for (std::string& variable : variables_) envp_.push_back(variable.data());
    argv_.push_back(nullptr);
    envp_.push_back(nullptr);
  }
  void Exec() { execvpe(argv_[0], argv_.data(), envp_.data()); }

 private:
  std::vector<std::string> words_, variables_;
  std::vector<char*> argv_, envp_;
};

tl::unexpected<core::Error> CannotStart(const Command& command, int error) {
  const bool is_ours = command.program.has_parent_path();
  return core::Fail(core::ErrorCode::kNotFound, "cannot start " + command.name + " (" + command.program.string() +
                                                    "): " + std::strerror(error) +
                                                    (is_ours ? "; build it first" : "; install it, apt.txt names it"));
}

// In the child, until exec: its errno when something went wrong.
int BecomeCommand(const Command& command, const Bond& bond, pid_t parent, ExecArguments* arguments) {
  prctl(PR_SET_PDEATHSIG, bond.signal_at_owners_end);
  if (getppid() != parent) _exit(127);  // the parent died before prctl took effect
  if (bond.group != Bond::Group::kCallers) setpgid(0, bond.given_group);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  for (const int number : {SIGINT, SIGTERM, SIGPIPE}) signal(number, SIG_DFL);
  if (bond.in_fd >= 0) dup2(bond.in_fd, STDIN_FILENO);
  if (bond.out_fd >= 0) dup2(bond.out_fd, STDOUT_FILENO);
  if (bond.err_fd >= 0) dup2(bond.err_fd, STDERR_FILENO);
  if (command.inherited_fd >= 0) fcntl(command.inherited_fd, F_SETFD, 0);
  if (!command.folder.empty() && chdir(command.folder.c_str()) != 0) return errno;
  if (command.nice != 0) {
    errno = 0;
    if (nice(command.nice) == -1 && errno != 0) {
      // Not being nice is no reason to fail: the kernel only refuses to raise the priority.
    }
  }
  arguments->Exec();
  return errno;
}

}  // namespace

std::string Exit::Describe() const {
  if (signal != 0) return "killed by signal " + std::to_string(signal) + " (" + strsignal(signal) + ")";
  return "exit status " + std::to_string(status);
}

core::Result<pid_t> Spawn(const Command& command, const Bond& bond) {
  ExecArguments arguments(command);
  // The child sends through this pipe why exec failed; a successful exec closes it.
  int failure[2];
  if (pipe2(failure, O_CLOEXEC) != 0) {
    return core::Fail(core::ErrorCode::kResource, std::string("cannot open a pipe: ") + std::strerror(errno));
  }
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid == 0) {
    const int error = BecomeCommand(command, bond, parent, &arguments);
    if (write(failure[1], &error, sizeof error) < 0) _exit(126);
    _exit(127);
  }
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
    return CannotStart(command, error);
  }
  return pid;
}

Exit Wait(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  Exit exit;
  (WIFSIGNALED(status) ? exit.signal : exit.status) = WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status);
  return exit;
}

tl::unexpected<core::Error> Replace(const Command& command) {
  ExecArguments(command).Exec();
  return CannotStart(command, errno);
}

}  // namespace process
