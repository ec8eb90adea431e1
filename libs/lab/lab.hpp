#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "scene/scenario.hpp"

namespace lab {

// Who starts, restarts and ends the processes of a host.
enum class SupervisorKind {
  kSupervisor,  // Debian's supervisor, with a configuration and a socket of the run's own
  kSystemd,     // systemd user units
};

struct Host {
  std::string name;
  std::string address;               // for ssh: a name or an IPv4 address
  std::string user;                  // empty: ssh's own choice
  std::uint16_t ssh_port = 0;        // 0: ssh's own choice
  std::filesystem::path ssh_config;  // empty: ssh's own; else absolute
  std::filesystem::path identity;    // private key's file; empty: ssh's own choice
  std::string bind;  // IPv4 address or interface that the others reach; empty: what `address` resolves to
  std::string run_folder = "vr_oos";  // on the host; relative: to the home of the user
  std::string programs;  // folder with the nodes' executables on the host; empty: the launcher's are pushed
  std::string cache;     // folder of cooked structures on the host; empty: the user's own
  SupervisorKind supervisor = SupervisorKind::kSupervisor;
  scene::Location where;
};

// A file on the host that the node must be able to open for a role's device.
struct DeviceAccess {
  std::string role;
  std::string path;
  scene::Location where;
};

struct Placement {
  std::string node;  // one of kNodeNames
  std::string host;
  std::string rt = "try";  // real-time priority: off, try, enforce
  std::string cores;       // "2,3" or "2-5"; empty: all
  std::string display;     // X display of a visual node; empty: no window
  std::vector<DeviceAccess> devices;
  scene::Location where;
};

// The machines of a laboratory, and which of them runs what. Whatever the scenario.
struct Lab {
  std::string name;
  std::filesystem::path file;  // absolute
  std::vector<Host> hosts;
  std::vector<Placement> placements;
  std::string registry_host;
  std::uint16_t registry_port = 7450;
  double max_clock_bound_ms = 20.0;  // beyond it the times of two machines tell nothing of each other
  double min_free_MB = 500.0;        // for logs and recordings, on each host
  std::string tcp_topics;            // LATEST topics that go by ZeroMQ, as bus::NodeOptions::tcp_topics; empty: none
  std::string multicast;             // group and port for LATEST, as bus::NodeOptions::multicast; empty: none

  [[nodiscard]] const Host* FindHost(const std::string& host_name) const;  // null: none
  [[nodiscard]] const Placement* FindPlacement(const std::string& node) const;
};

constexpr const char* kNodeNames[] = {"physics_node", "haptic_node", "logic_node", "visual_node", "device_bridge"};

}  // namespace lab
