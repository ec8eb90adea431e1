#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "scene/scenario.hpp"
#include "view/frustum.hpp"

namespace lab {

// The program that starts, restarts and stops the processes of a host.
enum class SupervisorKind {
  kSupervisor,  // Debian's supervisor, with a configuration and a socket for this run alone
  kSystemd,     // systemd user units
};

struct Host {
  std::string name;
  std::string address;               // for ssh: a name or an IPv4 address
  std::string user;                  // empty: ssh's own choice
  std::uint16_t ssh_port = 0;        // 0: ssh's own choice
  std::filesystem::path ssh_config;  // empty: ssh's own; else absolute
  std::filesystem::path identity;    // private key's file; empty: ssh's own choice
  std::string bind;  // IPv4 address or interface that the other hosts reach; empty: what `address` resolves to
  std::string run_folder = "vr_oos";  // on the host; relative: to the home of the user
  std::string programs;  // folder with the nodes' executables on the host; empty: the launcher copies its own there
  std::string cache;     // folder of cooked structures on the host; empty: the user's default
  SupervisorKind supervisor = SupervisorKind::kSupervisor;
  scene::Location where;
};

// A role's device on that host: another one than the scenario's, a file that the node must be able to open, or both.
struct DeviceAccess {
  std::string role;
  std::string path;     // empty: none
  std::string type;     // of scene::kDeviceTypes; empty: the scenario's
  std::string address;  // for that type
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

// Workers that trace the pictures of visual_node, on a host.
struct RayWorkers {
  std::string host;
  std::size_t count = 1;
  scene::Location where;
};

// What draws a viewer's pictures, and the program that does: of the page, which a browser draws, the one that tells it
// the scene.
enum class Renderer : std::uint8_t { kOpenGl, kRays, kHeadset, kPage };
struct RendererInfo {
  Renderer renderer;
  const char* name;  // in a lab file
  const char* program;
};
inline constexpr RendererInfo kRenderers[] = {{Renderer::kOpenGl, "opengl", "visual_node"},
                                              {Renderer::kRays, "rays", "rt_visual_node"},
                                              {Renderer::kHeadset, "headset", "headset_node"},
                                              {Renderer::kPage, "page", "scene_stream"}};
constexpr const char* ProgramOf(Renderer renderer) {
  return kRenderers[static_cast<std::size_t>(renderer)].program;
}

// A viewer of the run beside visual_node: node visual_node-<name>.
struct Viewer {
  std::string name;
  std::string host;
  std::string display;  // X display; empty: no window
  std::string camera;   // it stays with; empty: that of the step
  std::string layout;   // several views in one window, instead
  std::string stereo;   // empty: one picture for both eyes
  std::string user;     // for whose head it is drawn; empty: nobody's
  std::string size;     // "1280x720"; empty: the viewer's own
  Renderer renderer = Renderer::kOpenGl;
  std::size_t num_workers = 0;  // on its host, that trace its pictures: of rays
  std::uint16_t port = 0;       // on its host, of the page; else 0
  scene::Location where;
};

// A wall of a room: a window onto the scene, in metres from the room's viewpoint, x to the right, y ahead, z up.
struct Wall {
  Viewer viewer;  // all but its layout
  view::Screen screen_R;
  std::string place;  // "X,Y" of the window on the display; empty: it is placed by the window manager, with a frame
};

// Walls around one person, in step. The first one leads.
struct Room {
  std::string name;
  double eye_distance_m = 0.0;  // 0: the viewer's own
  std::vector<Wall> walls;
};

// The machines of a laboratory and the placement of the nodes on them, for any scenario.
struct Lab {
  std::string name;
  std::filesystem::path file;  // absolute
  std::vector<Host> hosts;
  std::vector<Placement> placements;
  std::vector<RayWorkers> ray_workers;  // none: visual_node draws with OpenGL
  std::vector<Viewer> viewers;
  std::vector<Room> rooms;
  std::string registry_host;
  std::uint16_t registry_port = 7450;
  // Largest accepted error bound of a host's clock offset. 20 ms is chosen without a study: latencies between machines
  // are of that order, so with a larger error they mean nothing. docs/howto/lab_example.xml uses 2 ms.
  double max_clock_bound_ms = 20.0;
  double min_free_MB = 500.0;  // for logs and recordings, on each host; chosen, not measured
  std::string tcp_topics;      // LATEST topics that go by ZeroMQ, as bus::NodeOptions::tcp_topics; empty: none
  std::string multicast;       // group and port for LATEST, as bus::NodeOptions::multicast; empty: none
  bool is_colocated = false;   // haptic_node and physics_node are one process, as haptic_node's placement says

  [[nodiscard]] bool traces_rays() const { return !ray_workers.empty(); }
  // Null when there is none.
  [[nodiscard]] const Host* FindHost(const std::string& host_name) const;
  [[nodiscard]] const Placement* FindPlacement(const std::string& node) const;
  // All viewers, those of walls included, that are on that host; empty: on any.
  [[nodiscard]] std::vector<const Viewer*> ViewersOn(const std::string& host_name) const;
  [[nodiscard]] bool HasPageOn(const std::string& host_name) const;
  // The programs that those need, each once.
  [[nodiscard]] std::vector<std::string> ProgramsOfViewersOn(const std::string& host_name) const;
};

// The value of `colocate`, the two nodes that it puts into one process, and that process's program.
constexpr const char* kColocate = "haptic physics";
constexpr const char* kColocatedNodes[] = {"haptic_node", "physics_node"};
constexpr const char* kColocatedProgram = "haptic_physics_node";

constexpr std::uint16_t kPagePort = 8765;  // unless the lab file says another; as tools/web_bridge

// The programs of a viewer whose pictures workers trace.
constexpr const char* kRayViewerProgram = ProgramOf(Renderer::kRays);
constexpr const char* kRayWorkerProgram = "rt_worker";

constexpr const char* kNodeNames[] = {"physics_node", "haptic_node", "logic_node", "visual_node", "device_bridge"};

}  // namespace lab
