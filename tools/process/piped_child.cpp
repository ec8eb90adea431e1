#include "tools/process/piped_child.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>

#include "core/clock.hpp"
#include "tools/process/spawn.hpp"

namespace process {
namespace {

void CloseFd(int* fd) {
  if (*fd >= 0) close(*fd);
  *fd = -1;
}

}  // namespace

core::Result<std::unique_ptr<PipedChild>> PipedChild::Start(const std::vector<std::string>& words) {
  int pipes[3][2];
  for (auto& ends : pipes) {
    if (pipe2(ends, O_CLOEXEC) != 0) {
      return core::Fail(core::ErrorCode::kResource, std::string("cannot open a pipe: ") + std::strerror(errno));
    }
  }
  Command command;
  command.name = words[0];
  command.program = words[0];
  command.arguments.assign(words.begin() + 1, words.end());
  Bond bond;
  bond.in_fd = pipes[0][0];
  bond.out_fd = pipes[1][1];
  bond.err_fd = pipes[2][1];
  bond.signal_at_owners_end = SIGTERM;
  const auto pid = Spawn(command, bond);
  close(pipes[0][0]);
  close(pipes[1][1]);
  close(pipes[2][1]);
  std::unique_ptr<PipedChild> child(new PipedChild);
  child->fds_[0] = pipes[0][1];
  child->fds_[1] = pipes[1][0];
  child->fds_[2] = pipes[2][0];
  if (!pid) {
    child->status_ = 127;
    return tl::unexpected(pid.error());
  }
  child->pid_ = *pid;
  for (const int fd : child->fds_) fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK);
  signal(SIGPIPE, SIG_IGN);  // that a child has gone shows in its exit status
  return child;
}

PipedChild::~PipedChild() {
  for (int& fd : fds_) CloseFd(&fd);
  if (pid_ <= 0 || status_) return;
  kill(pid_, SIGTERM);
  waitpid(pid_, nullptr, 0);
}

void PipedChild::Write(const std::string& text) {
  unwritten_ += text;
  Poll();
}

void PipedChild::CloseInput() {
  closes_input_ = true;
  Poll();
}

void PipedChild::ReadFrom(int* fd, std::string* text) {
  char buffer[16384];
  while (*fd >= 0) {
    const ssize_t got = read(*fd, buffer, sizeof buffer);
    if (got > 0) {
      text->append(buffer, static_cast<std::size_t>(got));
    } else if (got < 0 && (errno == EAGAIN || errno == EINTR)) {
      return;
    } else {
      CloseFd(fd);
    }
  }
}

void PipedChild::Poll() {
  while (fds_[0] >= 0 && !unwritten_.empty()) {
    const ssize_t put = write(fds_[0], unwritten_.data(), unwritten_.size());
    if (put < 0 && (errno == EAGAIN || errno == EINTR)) break;
    if (put < 0) {
      CloseFd(&fds_[0]);
      break;
    }
    unwritten_.erase(0, static_cast<std::size_t>(put));
  }
  if (closes_input_ && unwritten_.empty()) CloseFd(&fds_[0]);
  ReadFrom(&fds_[1], &out_);
  ReadFrom(&fds_[2], &err_);
  if (status_ || fds_[1] >= 0 || fds_[2] >= 0) return;
  int status = 0;
  if (waitpid(pid_, &status, WNOHANG) != pid_) return;
  status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

std::vector<std::string> PipedChild::TakeLines() {
  std::vector<std::string> lines;
  std::size_t begin = 0;
  for (std::size_t end = out_.find('\n'); end != std::string::npos; end = out_.find('\n', begin)) {
    lines.push_back(out_.substr(begin, end - begin));
    begin = end + 1;
  }
  out_.erase(0, begin);
  return lines;
}

void WaitForAny(const std::vector<PipedChild*>& children, int timeout_ms) {
  std::vector<pollfd> fds;
  for (const PipedChild* child : children) {
    if (child->out_fd() >= 0) fds.push_back({child->out_fd(), POLLIN, 0});
    if (child->err_fd() >= 0) fds.push_back({child->err_fd(), POLLIN, 0});
  }
  // Nothing to read but not ended: its exit status is a moment away.
  poll(fds.data(), fds.size(), fds.empty() ? 1 : timeout_ms);
}

std::vector<std::string> Answer::values(const std::string& key) const {
  std::vector<std::string> found;
  std::size_t begin = 0;
  while (begin < out.size()) {
    const std::size_t end = std::min(out.find('\n', begin), out.size());
    const std::string line = out.substr(begin, end - begin);
    if (line.rfind(key + "=", 0) == 0) found.push_back(line.substr(key.size() + 1));
    begin = end + 1;
  }
  return found;
}

std::string Answer::value(const std::string& key) const {
  const auto all = values(key);
  return all.empty() ? "" : all.front();
}

core::Result<Answer> RunHere(const std::vector<std::string>& words, const std::string& input, double patience_s) {
  auto child = PipedChild::Start(words);
  if (!child) return tl::unexpected(child.error());
  (*child)->Write(input);
  (*child)->CloseInput();
  Finish({child->get()}, patience_s);
  return AnswerOf(**child);
}

void Finish(const std::vector<PipedChild*>& children, double patience_s) {
  const std::int64_t deadline_ns = core::MonotonicNow_ns() + static_cast<std::int64_t>(patience_s * 1e9);
  while (core::MonotonicNow_ns() < deadline_ns) {
    bool any = false;
    for (PipedChild* child : children) {
      child->Poll();
      any = any || !child->has_ended();
    }
    if (!any) return;
    WaitForAny(children, 50);
  }
}

Answer AnswerOf(const PipedChild& child) {
  if (!child.has_ended()) return {124, child.out(), child.err() + "no answer in time"};
  return {child.status(), child.out(), child.err()};
}

}  // namespace process
