#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "tools/process/spawn.hpp"

namespace process {

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

  // SIGTERM to the children named (all when empty). Does not wait.
  void Terminate(const std::vector<std::string>& names = {});
  // SIGTERM to the children named (all when empty) and waits up to `patience_s`; then SIGKILL to what is left. Returns
  // the names that had to be killed. With an empty list nothing of the group is alive afterwards.
  std::vector<std::string> StopAll(double patience_s, const std::vector<std::string>& names = {});

 private:
  std::vector<Child> children_;
  pid_t group_ = 0;
};

}  // namespace process
