#include "tools/oos/attach/remote.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>

#include "core/clock.hpp"

namespace oos {
namespace {

constexpr double kConnectPatience_s = 15.0;

std::int64_t In_ns(double seconds) {
  return core::MonotonicNow_ns() + static_cast<std::int64_t>(seconds * 1e9);
}

void CloseFd(int* fd) {
  if (*fd >= 0) close(*fd);
  *fd = -1;
}

std::string LastLine(const std::string& text) {
  const std::size_t end = text.find_last_not_of("\r\n ");
  if (end == std::string::npos) return {};
  const std::size_t begin = text.find_last_of("\r\n", end);
  return text.substr(begin + 1, end - begin);
}

// Until all have ended or the time is over.
void Finish(const std::vector<PipedChild*>& children, double patience_s) {
  const std::int64_t deadline_ns = In_ns(patience_s);
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

}  // namespace

core::Result<std::unique_ptr<PipedChild>> PipedChild::Start(const std::vector<std::string>& words) {
  int pipes[3][2];
  for (auto& ends : pipes) {
    if (pipe2(ends, O_CLOEXEC) != 0) {
      return core::Fail(core::ErrorCode::kResource, std::string("cannot open a pipe: ") + std::strerror(errno));
    }
  }
  std::vector<std::string> copies = words;
  std::vector<char*> argv;
  for (std::string& word : copies) argv.push_back(word.data());
  argv.push_back(nullptr);
  const pid_t pid = fork();
  if (pid == 0) {
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    setpgid(0, 0);
    signal(SIGINT, SIG_DFL);
    signal(SIGTERM, SIG_DFL);
    signal(SIGPIPE, SIG_DFL);
    dup2(pipes[0][0], STDIN_FILENO);
    dup2(pipes[1][1], STDOUT_FILENO);
    dup2(pipes[2][1], STDERR_FILENO);
    execvp(argv[0], argv.data());
    dprintf(STDERR_FILENO, "cannot run %s: %s; apt-get install what apt.txt names\n", argv[0], std::strerror(errno));
    _exit(127);
  }
  std::unique_ptr<PipedChild> child(new PipedChild);
  child->pid_ = pid;
  close(pipes[0][0]);
  close(pipes[1][1]);
  close(pipes[2][1]);
  child->fds_[0] = pipes[0][1];
  child->fds_[1] = pipes[1][0];
  child->fds_[2] = pipes[2][0];
  if (pid < 0) {
    child->status_ = 127;
    return core::Fail(core::ErrorCode::kResource, "cannot fork: " + std::string(std::strerror(errno)));
  }
  for (const int fd : child->fds_) fcntl(fd, F_SETFL, fcntl(fd, F_GETFL) | O_NONBLOCK);
  signal(SIGPIPE, SIG_IGN);  // a child that has gone is told by its exit status
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

Remotes::~Remotes() {
  masters_.clear();
  std::error_code error;
  if (!folder_.empty()) std::filesystem::remove_all(folder_, error);
}

std::filesystem::path Remotes::Socket(std::size_t host) const {
  return folder_ / std::to_string(host);
}

core::Result<std::unique_ptr<PipedChild>> Remotes::StartMaster(std::size_t i) const {
  const lab::Host& host = hosts_[i];
  std::vector<std::string> words = {"ssh", "-N", "-T"};
  if (!host.ssh_config.empty()) words.insert(words.end(), {"-F", host.ssh_config.string()});
  if (!host.identity.empty()) {
    words.insert(words.end(), {"-i", host.identity.string(), "-o", "IdentitiesOnly=yes"});
  }
  if (host.ssh_port != 0) words.insert(words.end(), {"-p", std::to_string(host.ssh_port)});
  if (!host.user.empty()) words.insert(words.end(), {"-l", host.user});
  for (const char* option :
       {"BatchMode=yes", "ConnectTimeout=8", "ServerAliveInterval=2", "ServerAliveCountMax=5", "ControlMaster=yes"}) {
    words.insert(words.end(), {"-o", option});
  }
  words.insert(words.end(), {"-S", Socket(i).string(), "--", host.address});
  return PipedChild::Start(words);
}

bool Remotes::Reconnect(std::size_t host) {
  std::unique_ptr<PipedChild>& master = masters_[host];
  master->Poll();
  std::error_code error;
  if (!master->has_ended()) return std::filesystem::exists(Socket(host), error);
  std::filesystem::remove(Socket(host), error);
  if (auto again = StartMaster(host)) master = std::move(*again);
  return false;
}

core::Result<void> Remotes::Connect() {
  const auto complaints = Reach();
  if (!complaints) return tl::unexpected(complaints.error());
  std::string text;
  for (const std::string& complaint : *complaints) text += (text.empty() ? "" : "\n") + complaint;
  if (!text.empty()) return core::Fail(core::ErrorCode::kIo, text);
  return {};
}

core::Result<std::vector<std::string>> Remotes::Reach() {
  // Short: the name of a Unix socket has 107 characters at most.
  char name[] = "/tmp/oos-ssh-XXXXXX";
  if (mkdtemp(name) == nullptr) return core::Fail(core::ErrorCode::kIo, "cannot make a folder in /tmp");
  folder_ = name;
  for (std::size_t i = 0; i < hosts_.size(); ++i) {
    auto master = StartMaster(i);
    if (!master) return tl::unexpected(master.error());
    masters_.push_back(std::move(*master));
  }
  std::vector<std::string> complaints;
  const std::int64_t deadline_ns = In_ns(kConnectPatience_s);
  for (std::size_t i = 0; i < hosts_.size(); ++i) {
    PipedChild& master = *masters_[i];
    std::error_code error;
    while (!std::filesystem::exists(Socket(i), error) && !master.has_ended() && core::MonotonicNow_ns() < deadline_ns) {
      master.Poll();
      WaitForAny({&master}, 5);
    }
    is_reached_.push_back(std::filesystem::exists(Socket(i), error));
    if (is_reached_.back()) continue;
    complaints.push_back("host " + hosts_[i].name + " (" + hosts_[i].address +
                         ") does not let us in: " + (master.err().empty() ? "no answer" : LastLine(master.err())) +
                         "; try: ssh " + hosts_[i].address);
  }
  return complaints;
}

std::vector<std::string> Remotes::Ssh(std::size_t host) const {
  // Through the open connection or not at all.
  return {"ssh",
          "-F",
          "none",
          "-S",
          Socket(host).string(),
          "-o",
          "ControlMaster=no",
          "-o",
          "ProxyCommand=false",
          "-o",
          "BatchMode=yes",
          "-T",
          "--",
          hosts_[host].address};
}

std::vector<Answer> Remotes::RunAll(const std::vector<std::string>& scripts, double patience_s) {
  std::vector<std::unique_ptr<PipedChild>> children(scripts.size());
  std::vector<PipedChild*> started;
  for (std::size_t i = 0; i < scripts.size(); ++i) {
    if (scripts[i].empty()) continue;
    auto words = Ssh(i);
    words.insert(words.end(), {"sh", "-s"});
    auto child = PipedChild::Start(words);
    if (!child) continue;
    (*child)->Write(scripts[i]);
    (*child)->CloseInput();
    started.push_back(child->get());
    children[i] = std::move(*child);
  }
  Finish(started, patience_s);
  std::vector<Answer> answers;
  for (std::size_t i = 0; i < scripts.size(); ++i) {
    if (scripts[i].empty()) {
      answers.push_back({0, "", ""});
    } else {
      answers.push_back(children[i] ? AnswerOf(*children[i]) : Answer{127, "", "cannot start ssh"});
    }
  }
  return answers;
}

Answer Remotes::Run(std::size_t host, const std::string& script, double patience_s) {
  std::vector<std::string> scripts(hosts_.size());
  scripts[host] = script;
  return RunAll(scripts, patience_s)[host];
}

core::Result<std::unique_ptr<PipedChild>> Remotes::Open(std::size_t host, const std::string& command) {
  auto words = Ssh(host);
  words.push_back(command);
  return PipedChild::Start(words);
}

std::vector<std::string> Remotes::Rsync(std::size_t host) const {
  const std::string ssh =
      "ssh -F none -S " + Socket(host).string() + " -o ControlMaster=no -o ProxyCommand=false -o BatchMode=yes";
  return {"rsync", "-a", "--timeout=60", "-e", ssh};
}

std::string Remotes::Target(std::size_t host, const std::string& path) const {
  return hosts_[host].address + ":" + path;
}

}  // namespace oos
