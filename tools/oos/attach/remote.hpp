#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "lab/lab.hpp"
#include "tools/process/piped_child.hpp"

namespace oos {

using process::Answer;
using process::PipedChild;
using process::RunHere;
using process::WaitForAny;

// The hosts of a lab over OpenSSH: one connection each (ControlMaster), which everything shares.
class Remotes {
 public:
  explicit Remotes(std::vector<lab::Host> hosts) : hosts_(std::move(hosts)) {}
  ~Remotes();
  Remotes(const Remotes&) = delete;
  Remotes& operator=(const Remotes&) = delete;

  // Connects to all hosts. Errors: every host that cannot be reached, with ssh's message.
  core::Result<void> Connect();
  // Connects to the hosts that can be reached; reports each of the others in `complaints`.
  core::Result<std::vector<std::string>> Reach();
  [[nodiscard]] bool is_reached(std::size_t host) const { return is_reached_[host]; }

  // Connects again to a host that has fallen silent. Does not wait: call it until it returns true.
  bool Reconnect(std::size_t host);

  [[nodiscard]] const std::vector<lab::Host>& hosts() const { return hosts_; }
  // Runs a script of /bin/sh on each host at the same time; skips a host whose script is empty (status 0).
  std::vector<Answer> RunAll(const std::vector<std::string>& scripts, double patience_s = 60.0);
  Answer Run(std::size_t host, const std::string& script, double patience_s = 60.0);
  // Starts a command on a host that runs until it is stopped.
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
