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
  std::vector<std::string> viewer_programs;  // of all viewers of the lab
  std::function<void(const std::string&)> say;
};

// Facts of each host, in the order of `Remotes::hosts()`.
using AllFacts = std::map<std::string, lab::HostFacts>;

// Checks every host's run folder, address, disk, tools and the registry's port. Makes the run folder, and changes
// nothing else. Errors: one line for each thing that is wrong, with the host's name and the remedy.
core::Result<AllFacts> AskHosts(const lab::Lab& lab, Remotes* remotes);

// Copies to every host the executables and scenario files that it lacks, and those of the page where a viewer is one;
// files with the same hash are not copied. Fills in where they are.
core::Result<void> Push(const lab::Lab& lab, const scene::Scenario& scenario, const PreflightOptions& options,
                        Remotes* remotes, AllFacts* facts);

// After the executables are in place: checks libraries, real-time limits, devices, display and the bound of the clocks.
core::Result<void> CheckHosts(const lab::Lab& lab, const PreflightOptions& options, Remotes* remotes,
                              const AllFacts& facts);

}  // namespace oos
