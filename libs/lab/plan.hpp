#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lab/lab.hpp"

namespace lab {

// Facts about a host, collected from it before the plan is made. For a plan that is only printed they are assumed from
// the lab file, without contacting the host.
struct HostFacts {
  std::string root;      // absolute run folder of the host
  std::string bind;      // IPv4 address of its sockets
  std::string programs;  // folder with the executables
  std::string scenario;  // the scenario's file there
  std::string home;      // of the user, for systemd's unit folder
  std::string display;   // free display number for an X server there, e.g. ":120"
  std::string page;      // project folder with tools/web_bridge; empty: no viewer there is a page
  std::string stubs;     // folder with the types of messages, for the page
};

struct PlanOptions {
  std::string run;            // name of the run: letters, digits, '-', '_'
  std::uint64_t session = 0;  // number of the session on the bus
  std::string method;
  std::uint64_t seed = 0;
  unsigned workers = 1;
  bool is_recorded = false;
  bool records_steps = false;  // the nodes that can be replayed record their steps into the run folder's steps/
  bool has_keys = false;
  std::vector<std::string> without;
};

// How long a process has after SIGTERM. A viewer writes its last pictures, as after `oos view`: on a busy machine
// without a GPU one that is kept takes seconds.
constexpr int kStopPatience_s = 3;
constexpr int kViewerStopPatience_s = 10;

// One supervised process.
struct Unit {
  std::string name;
  std::vector<std::string> nodes;  // on the bus; a tool has none
  bool has_tools_key = false;      // it is on the bus as `oos`, too
  std::string program;             // absolute
  std::vector<std::string> arguments;
  std::map<std::string, std::string> environment;
  std::string cores;   // empty: all
  std::string socket;  // the unit starts when this socket exists; empty: at once
  std::string log;     // absolute
  int stop_patience_s = kStopPatience_s;
};

struct HostPlan {
  Host host;
  HostFacts facts;
  std::string run_folder;   // of this run, absolute
  std::vector<Unit> units;  // the registry first, then in the lab file's order
};

struct Plan {
  std::string run;
  std::string registry;  // endpoint
  std::uint64_t session = 0;
  std::vector<HostPlan> hosts;  // those with at least one unit, in the lab file's order
};

// Folder in which a host keeps the keys of its running session. Its content is never collected with the results.
std::string KeyFolder(const HostFacts& facts);

// Endpoint of the registry. `facts` must contain its host.
std::string RegistryEndpoint(const Lab& lab, const std::map<std::string, HostFacts>& facts);

// Assigns processes and their command lines to hosts. `facts` must contain every host of the lab.
Plan MakePlan(const Lab& lab, const std::map<std::string, HostFacts>& facts, const PlanOptions& options);

// The options of visual_node that make it this viewer, and this wall of its room.
std::vector<std::string> ViewerArguments(const Viewer& viewer);
std::vector<std::string> WallArguments(const Room& room, const Wall& wall);

// Readable text: hosts, units and their commands.
std::string Describe(const Plan& plan);

}  // namespace lab
