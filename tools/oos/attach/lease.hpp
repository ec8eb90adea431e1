#pragma once

#include <map>
#include <string>
#include <vector>

#include "tools/oos/attach/remote.hpp"

namespace oos {

// Who uses a host: a file in its run folder, made by one launcher at a time, which names the run. What is needed to
// look at the run, to stop it and to fetch what it left is found through it, from any terminal.
struct Lease {
  std::map<std::string, std::string> values;  // run, who, pid, boot, scenario, lab, out, registry,
                                              // session, since; stopping: who ends it
  [[nodiscard]] std::string value(const std::string& key) const;
  // "anna@desk (process 12) runs touch-... since ..."
  [[nodiscard]] std::string Describe() const;
};

struct HostState {
  std::string root;  // empty: the run folder is not there
  Lease lease;       // without values: nobody uses the host
};

// In the order of the hosts; of a host that was not reached nothing is known.
core::Result<std::vector<HostState>> ReadLeases(Remotes* remotes);

// The run of a lab that was launched with this very file; else the first that is found. Without values: none runs.
Lease ChooseRun(const std::vector<HostState>& states, const std::string& lab_file);

// A run's name and folders become part of remote commands: letters, digits and the characters / . _ + @ - alone.
[[nodiscard]] bool IsPlain(const std::string& path);

// "anna@desk"
std::string WhoIsHere();

// Below, `roots` are in the order of the hosts; a host whose root is empty has nothing of the run and is left alone.

// The error names who has a host.
core::Result<void> CheckFree(Remotes* remotes);

// On all hosts or on none. The error names who has the host.
core::Result<void> TakeLeases(const Lease& lease, const std::vector<std::string>& roots, Remotes* remotes);

// Lets the run's launcher know, if it lives, that `who` ends the run and collects what it leaves.
void MarkStopping(const std::string& run, const std::string& who, const std::vector<std::string>& roots,
                  Remotes* remotes);
// Only those of the run, with its keys.
void ReleaseLeases(const std::string& run, const std::vector<std::string>& roots, Remotes* remotes);

// Stops a run in two phases, by the hosts' own supervisors, and looks for what is left of it. Empty when nothing is;
// else a line for each process, or for a host that did not answer.
std::vector<std::string> StopRun(const std::string& run, const std::vector<std::string>& roots, Remotes* remotes);

// Fetches what the run left on all hosts into one folder, then removes it there.
core::Result<void> Collect(const std::string& run, const std::vector<std::string>& roots,
                           const std::filesystem::path& out, Remotes* remotes);

}  // namespace oos
