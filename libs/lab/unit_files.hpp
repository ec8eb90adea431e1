#pragma once

#include <map>
#include <string>
#include <vector>

#include "lab/plan.hpp"

namespace lab {

// How a host's own supervisor is told to run its part of a plan: files for the run folder, and scripts for /bin/sh on
// the host. The supervisor starts, restarts and kills; nothing here does.
struct UnitFiles {
  std::map<std::string, std::string> files;  // name in the run folder -> text
  std::string start;                         // all units
  std::string resume;  // the same on a host that may have been switched off since: what still runs is left alone
  std::string stop;    // SIGTERM, 3 s of patience, SIGKILL to the whole group; returns when all have ended
  std::string status;  // one line a unit: name, state (running, starting, failed, stopped), what else is known
};

// For Debian's supervisor: one supervisord with a socket in the host's root folder.
UnitFiles SupervisorFiles(const HostPlan& plan);

// systemd user units, one a node, in the user's unit folder while the run lasts.
UnitFiles SystemdFiles(const HostPlan& plan);

UnitFiles FilesFor(const HostPlan& plan);

// The words that start a unit: its program and arguments, behind a wait for its socket.
std::vector<std::string> WordsOf(const Unit& unit);

}  // namespace lab
