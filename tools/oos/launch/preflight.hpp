#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "lab/lab.hpp"
#include "lab/plan.hpp"
#include "scene/scenario.hpp"
#include "tools/oos/attach/remote.hpp"

namespace oos {

struct PreflightOptions {
  std::filesystem::path programs;  // this machine's executables
  std::vector<std::string> without;
  std::function<void(const std::string&)> say;
};

// Facts of each host, in the order of `Remotes::hosts()`.
using AllFacts = std::map<std::string, lab::HostFacts>;

// Asks every host what it has: run folder, address, disk, tools, the registry's port. Changes nothing but the run
// folder, which it makes. Errors: one line for each thing that is wrong, with the host's name and the remedy.
core::Result<AllFacts> AskHosts(const lab::Lab& lab, Remotes* remotes);

// Brings to every host what it lacks of the executables and of the scenario's files, both by content: what is there
// with the same hashes stays. Fills in where they are.
core::Result<void> Push(const scene::Scenario& scenario, const PreflightOptions& options, Remotes* remotes,
                        AllFacts* facts);

// With the executables in place: libraries, real-time limits, devices, display, the bound of the clocks.
core::Result<void> CheckHosts(const lab::Lab& lab, const PreflightOptions& options, Remotes* remotes,
                              const AllFacts& facts);

}  // namespace oos
