#pragma once

#include <map>
#include <string>
#include <vector>

#include "tools/oos/remote.hpp"

namespace oos {

// Who uses a host: a file in its run folder, made by one launcher at a time, which names the run. What is needed to
// look at the run, to stop it and to fetch what it left is found through it, from any terminal.
struct Lease {
  std::map<std::string, std::string> values;  // run, who, pid, boot, scenario, lab, out, since
  [[nodiscard]] std::string value(const std::string& key) const;
  // "anna@desk (process 12) runs touch-... since ..."
  [[nodiscard]] std::string Describe() const;
};

struct HostState {
  std::string root;  // empty: the run folder is not there
  Lease lease;       // without values: nobody uses the host
};

// In the order of the hosts.
core::Result<std::vector<HostState>> ReadLeases(Remotes* remotes);

// The error names who has a host.
core::Result<void> CheckFree(Remotes* remotes);

// On all hosts or on none. `roots`: the hosts' run folders. The error names who has the host.
core::Result<void> TakeLeases(const Lease& lease, const std::vector<std::string>& roots, Remotes* remotes);

void ReleaseLeases(const std::string& run, const std::vector<std::string>& roots, Remotes* remotes);

// Stops a run in two phases, by the hosts' own supervisors, and looks for what is left of it. Empty when nothing is;
// else a line for each process, or for a host that did not answer.
std::vector<std::string> StopRun(const std::string& run, const std::vector<std::string>& roots, Remotes* remotes);

// Fetches what the run left on all hosts into one folder, then removes it there.
core::Result<void> Collect(const std::string& run, const std::vector<std::string>& roots,
                           const std::filesystem::path& out, Remotes* remotes);

}  // namespace oos
