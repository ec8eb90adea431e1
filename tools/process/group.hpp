#pragma once

#include <sys/types.h>

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace process {

// How a child ended.
struct Exit {
  int status = 0;  // exit status, when it ended by itself
  int signal = 0;  // signal number that ended it; 0: none
  [[nodiscard]] bool is_clean() const { return signal == 0 && status == 0; }
  [[nodiscard]] std::string Describe() const;  // "exit status 3", "killed by signal 9 (Killed)"
};

struct Command {
  std::string name;
  std::filesystem::path program;
  std::vector<std::string> arguments;
  std::map<std::string, std::string> environment;  // beside the caller's own
  std::filesystem::path log;                       // stdout and stderr
  int nice = 0;                                    // added to the caller's
  int inherited_fd = -1;                           // stays open in the child under the same number
};

// The children of one run, in one process group of their own: nobody outlives `StopAll`, and when the owner itself dies
// the kernel ends them (PR_SET_PDEATHSIG). Children must be spawned by the thread that lives as long as the owner.
class Group {
 public:
  Group() = default;
  Group(const Group&) = delete;
  Group& operator=(const Group&) = delete;
  ~Group() { StopAll(3.0); }

  core::Result<pid_t> Spawn(const Command& command);

  struct Child {
    std::string name;
    pid_t pid = -1;
    std::optional<Exit> exit;
  };
  // Collects children that have ended since the last call; returns their indices into `children`.
  std::vector<std::size_t> Reap();
  [[nodiscard]] const std::vector<Child>& children() const { return children_; }
  [[nodiscard]] bool IsRunning(const std::string& name) const;

  // SIGTERM to the children named (all when empty) and waits up to `patience_s`; then SIGKILL to what is left. Returns
  // the names that had to be killed. With an empty list nothing of the group is alive afterwards.
  std::vector<std::string> StopAll(double patience_s, const std::vector<std::string>& names = {});

 private:
  std::vector<Child> children_;
  pid_t group_ = 0;
};

}  // namespace process
