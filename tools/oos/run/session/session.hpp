#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/messages/logic.hpp"
#include "core/result.hpp"
#include "scene/scenario.hpp"
#include "tools/process/group.hpp"

namespace oos {

struct SessionOptions {
  std::filesystem::path out;                      // of this run; made when missing
  std::optional<std::uint64_t> seed;              // default: the scenario's
  std::optional<double> duration_s;               // default: the scenario's limit
  std::vector<std::string> without;               // nodes that are not started
  std::string hand = "script";                    // who moves simulated arms: script | pointer
  std::vector<std::string> devices;               // other ones for roles, ROLE=TYPE:ADDRESS
  bool is_colocated = false;                      // haptic_node and physics_node are one process
  std::string tcp_topics, multicast;              // for the nodes, bus/node.hpp; empty: none
  bool is_encrypted = true;                       // keys are made for the run, and removed at its end
  bool is_headless = false;                       // pictures are rendered, no window is shown
  std::string show;                               // what the viewer shows over the scene at first; empty: its default
  unsigned rays = 0;                              // visual_node's pictures are traced by so many workers; 0: OpenGL
  std::string rt = "try";                         // try | off
  unsigned workers = 1;                           // of haptic_node, and of physics_node
  std::filesystem::path program_folder;           // where the nodes' executables are
  bool is_recorded = false;                       // every node writes out/recording/<node>.mcap
  std::filesystem::path steps;                    // nodes write steps/<node>.mcap; empty: none
  std::string split_MB, split_s;                  // new files of the recording at that size or age; empty: none
  double start_patience_s = 240.0;                // cooking a big scene for the first time takes minutes
  const std::atomic<int>* interrupted = nullptr;  // not 0: stop, somebody pressed Ctrl-C
  std::function<void(const std::string&)> say;    // progress for people, one line each
  // Called during the run, e.g. to kill a node in a test; `force_N` is the force commanded to the first hand. The
  // session subscribes to commands only if this is set: each costs the haptic node a datagram.
  std::function<void(process::Group&, double seconds, double force_N)> while_running;
};

// How a session ended.
struct SessionOutcome {
  bool is_final = false;  // the procedure reached its final state
  std::string why;        // when not: the reason, with the step and the node that it names
  std::string last_step;
  bool had_window = false;
  double seconds = 0.0;  // from readiness to the end
  std::uint64_t seed = 0;
  std::vector<std::string> dead;    // nodes that ended by themselves: name and how
  std::vector<std::string> killed;  // nodes that did not end on SIGTERM
  std::vector<core::Event> events;  // all that were received
};

constexpr const char* kNodeNames[] = {"physics_node", "haptic_node", "logic_node", "visual_node", "device_bridge"};

// Where the nodes of a run leave their recordings.
std::filesystem::path RecordingFolder(const std::filesystem::path& out);

// Starts a registry and the nodes as processes of one group, waits until they are ready, watches them until the
// procedure ends (or fails, or the limit is reached, or a node dies), stops all. A run goes on when its viewer dies. No
// child is left when this returns.
core::Result<SessionOutcome> RunSession(const scene::Scenario& scenario, const SessionOptions& options);

}  // namespace oos
