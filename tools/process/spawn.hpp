#pragma once

#include <sys/types.h>

#include <csignal>
#include <filesystem>
#include <map>
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

// What is started.
struct Command {
  std::string name;               // for messages
  std::filesystem::path program;  // without a slash it is looked up in PATH
  std::vector<std::string> arguments;
  std::map<std::string, std::string> environment;  // beside the caller's own
  std::filesystem::path log;                       // stdout and stderr of a child of a Group
  int nice = 0;                                    // added to the caller's
  int inherited_fd = -1;                           // stays open in the child under the same number
  std::filesystem::path folder{};                  // to work in; empty: the caller's
};

// How the child hangs together with its owner.
struct Bond {
  int in_fd = -1, out_fd = -1, err_fd = -1;  // the child's stdin, stdout and stderr; -1: the caller's
  enum class Group { kOwn, kCallers, kGiven } group = Group::kOwn;
  pid_t given_group = 0;
  int signal_at_owners_end = SIGKILL;  // sent by the kernel (PR_SET_PDEATHSIG)
};

// Starts a child; the caller waits for it. Call it from a thread that lives as long as the owner: the kernel counts
// that thread's end as the owner's. Errors: kNotFound, when the program cannot be started; kResource.
core::Result<pid_t> Spawn(const Command& command, const Bond& bond);

// Until the child has ended.
Exit Wait(pid_t child);

// Runs the program in place of this one. Returns only when that fails.
tl::unexpected<core::Error> Replace(const Command& command);

}  // namespace process
