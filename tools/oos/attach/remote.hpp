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
