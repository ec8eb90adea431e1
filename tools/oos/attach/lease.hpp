#pragma once

#include <map>
#include <string>
#include <vector>

#include "tools/oos/attach/remote.hpp"

namespace oos {

// States who uses a host: a file in its run folder, made by one launcher at a time, that names the run. Any terminal
// finds through it what it needs to observe the run, to stop it and to collect its files.
struct Lease {
  std::map<std::string, std::string> values;  // run, who, pid, boot, scenario, lab, out, registry,
                                              // session, since; stopping: the user who ends it
  [[nodiscard]] std::string value(const std::string& key) const;
  // "anna@desk (process 12) runs touch-... since ..."
  [[nodiscard]] std::string Describe() const;
};

struct HostState {
  std::string root;  // run folder; empty: it does not exist
  Lease lease;       // without values: the host is free
};

// In the order of the hosts; empty for a host that was not reached.
core::Result<std::vector<HostState>> ReadLeases(Remotes* remotes);

// The lease of the run that was launched with this lab file, else of the first one found; without values if none runs.
Lease ChooseRun(const std::vector<HostState>& states, const std::string& lab_file);

// Whether a path may become part of a remote command: only letters, digits and the characters / . _ + @ -.
[[nodiscard]] bool IsPlain(const std::string& path);

// "anna@desk"
std::string UserAtHost();

// Below, `roots` are in the order of the hosts. An empty root means that the host has no part of the run: it is
// skipped.

// Errors: a host is in use; names by whom.
core::Result<void> CheckFree(Remotes* remotes);

// Takes the leases of all hosts or of none. Errors: a host is in use; names by whom.
core::Result<void> TakeLeases(const Lease& lease, const std::vector<std::string>& roots, Remotes* remotes);

// Notes in the leases that `who` ends the run and collects its files; the launcher, if it lives, reads it there.
void MarkStopping(const std::string& run, const std::string& who, const std::vector<std::string>& roots,
                  Remotes* remotes);
// Removes the leases and keys of this run only.
void ReleaseLeases(const std::string& run, const std::vector<std::string>& roots, Remotes* remotes);

// Stops a run in two phases, by the hosts' own supervisors. Returns a line for each process that is left and for each
// host that did not answer; empty if there are none.
std::vector<std::string> StopRun(const std::string& run, const std::vector<std::string>& roots, Remotes* remotes);

// Moves the run's files from all hosts into one local folder.
core::Result<void> Collect(const std::string& run, const std::vector<std::string>& roots,
                           const std::filesystem::path& out, Remotes* remotes);

}  // namespace oos
