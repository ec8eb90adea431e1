#pragma once

#include <sys/types.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "lab/lab.hpp"

namespace oos {

// A child process at the other end of pipes. In a process group of its own, so that a Ctrl-C at the terminal reaches
// only the launcher; ends when the launcher does.
class PipedChild {
 public:
  static core::Result<std::unique_ptr<PipedChild>> Start(const std::vector<std::string>& words);
  ~PipedChild();
  PipedChild(const PipedChild&) = delete;
  PipedChild& operator=(const PipedChild&) = delete;

  void Write(const std::string& text);
  void CloseInput();
  // Takes what has come on stdout and stderr, and the exit status when all has. Does not wait.
  void Poll();
  [[nodiscard]] bool has_ended() const { return status_.has_value(); }
  [[nodiscard]] int status() const { return status_.value_or(-1); }
  [[nodiscard]] const std::string& out() const { return out_; }
  [[nodiscard]] const std::string& err() const { return err_; }
  // Removes and returns the complete lines of stdout.
  std::vector<std::string> TakeLines();
  [[nodiscard]] pid_t pid() const { return pid_; }
  [[nodiscard]] int out_fd() const { return fds_[1]; }
  [[nodiscard]] int err_fd() const { return fds_[2]; }

 private:
  PipedChild() = default;
  void ReadFrom(int* fd, std::string* text);

  pid_t pid_ = -1;
  int fds_[3] = {-1, -1, -1};
  std::string unwritten_, out_, err_;
  bool closes_input_ = false;
  std::optional<int> status_;
};

// Waits until one of the children has something to say, at most `timeout_ms`.
void WaitForAny(const std::vector<PipedChild*>& children, int timeout_ms);

struct Answer {
  int status = -1;
  std::string out, err;
  [[nodiscard]] bool is_good() const { return status == 0; }
  // Values of the lines "key=value" of stdout.
  [[nodiscard]] std::vector<std::string> values(const std::string& key) const;
  [[nodiscard]] std::string value(const std::string& key) const;  // the first; empty: none
};

// A command of this machine, with `input` on its stdin.
core::Result<Answer> RunHere(const std::vector<std::string>& words, const std::string& input = "",
                             double patience_s = 60.0);

// The hosts of a lab over OpenSSH: one connection each (ControlMaster), which everything shares.
class Remotes {
 public:
  explicit Remotes(std::vector<lab::Host> hosts) : hosts_(std::move(hosts)) {}
  ~Remotes();
  Remotes(const Remotes&) = delete;
  Remotes& operator=(const Remotes&) = delete;

  // Names every host that cannot be reached, and ssh's own words.
  core::Result<void> Connect();
  // The same, content with those that can be: what is wrong with each of the others.
  core::Result<std::vector<std::string>> Reach();
  [[nodiscard]] bool is_reached(std::size_t host) const { return is_reached_[host]; }

  // For a host that was reached and has fallen silent. True when it is reached again; does not wait: call it again.
  bool Reconnect(std::size_t host);

  [[nodiscard]] const std::vector<lab::Host>& hosts() const { return hosts_; }
  // Runs a script of /bin/sh on each host at once; a host whose script is empty is left alone (status 0).
  std::vector<Answer> RunAll(const std::vector<std::string>& scripts, double patience_s = 60.0);
  Answer Run(std::size_t host, const std::string& script, double patience_s = 60.0);
  // A command on a host that goes on until it is ended.
  core::Result<std::unique_ptr<PipedChild>> Open(std::size_t host, const std::string& command);
  // The words before rsync's sources and target; the target is "HOST:path" with Target().
  [[nodiscard]] std::vector<std::string> Rsync(std::size_t host) const;
  [[nodiscard]] std::string Target(std::size_t host, const std::string& path) const;

 private:
  [[nodiscard]] std::vector<std::string> Ssh(std::size_t host) const;
  [[nodiscard]] core::Result<std::unique_ptr<PipedChild>> StartMaster(std::size_t host) const;
  [[nodiscard]] std::filesystem::path Socket(std::size_t host) const;

  std::vector<lab::Host> hosts_;
  std::filesystem::path folder_;  // of the sockets
  std::vector<std::unique_ptr<PipedChild>> masters_;
  std::vector<bool> is_reached_;  // at the beginning
};

}  // namespace oos
