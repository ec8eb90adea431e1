#pragma once

#include <map>
#include <string>
#include <vector>

#include "lab/plan.hpp"

namespace lab {

// Configuration for a host's supervisor: files for the run folder, and /bin/sh scripts that the launcher runs on the
// host. Only the supervisor starts, restarts and kills processes.
struct UnitFiles {
  std::map<std::string, std::string> files;  // name in the run folder -> text
  std::string start;                         // all units
  std::string resume;  // starts the units that do not run, on a host that may have been switched off meanwhile
  std::string stop;    // SIGTERM, after Unit::stop_patience_s SIGKILL to the whole group; returns when all have ended
  std::string status;  // one line per unit: name, state (running, starting, failed, stopped), details
};

// For Debian's supervisor: one supervisord with a socket in the host's root folder.
UnitFiles SupervisorFiles(const HostPlan& plan);

// systemd user units, one per node, in the user's unit folder while the run lasts.
UnitFiles SystemdFiles(const HostPlan& plan);

UnitFiles FilesFor(const HostPlan& plan);

// Command line of a unit: its program and arguments, preceded by a wait for its socket.
std::vector<std::string> WordsOf(const Unit& unit);

}  // namespace lab
