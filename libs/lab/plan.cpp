#include "lab/plan.hpp"

#include <algorithm>
#include <cstdio>

#include "tiles/seats.hpp"

namespace lab {
namespace {

// How long a procedure waits for a node that has ended. Chosen, not measured: a computer boots in less.
constexpr int kComebackPatience_s = 120;

class Planner {
 public:
  Planner(const Lab& lab, const std::map<std::string, HostFacts>& facts, const PlanOptions& options)
      : lab_(lab), facts_(facts), options_(options) {}

  Plan Make() {
    plan_.run = options_.run;
    plan_.session = options_.session;
    plan_.registry = RegistryEndpoint(lab_, facts_);
    for (const Host& host : lab_.hosts) {
      HostPlan plan;
      plan.host = host;
      plan.facts = facts_.at(host.name);
      plan.run_folder = plan.facts.root + "/runs/" + options_.run;
      if (host.name == lab_.registry_host) AddRegistry(&plan);
      for (const Placement& placement : lab_.placements) {
        const bool is_out =
            std::find(options_.without.begin(), options_.without.end(), placement.node) != options_.without.end();
        const bool is_in_pair = lab_.is_colocated && placement.node == "physics_node";  // with haptic_node
        if (placement.host == host.name && !is_out && !is_in_pair) AddNode(placement, &plan);
      }
      AddRayWorkers(&plan);
      for (const Viewer& viewer : lab_.viewers) {
        if (viewer.host != host.name) continue;
        if (viewer.renderer == Renderer::kPage) {
          AddPage(viewer, &plan);
        } else {
          AddViewer(viewer, NewViewer(viewer, &plan), &plan);
        }
      }
      for (const Room& room : lab_.rooms) AddWalls(room, &plan);
      if (!plan.units.empty()) plan_.hosts.push_back(std::move(plan));
    }
    return std::move(plan_);
  }

 private:
  Unit NewUnit(const HostPlan& plan, const std::string& name, const std::string& program) const {
    Unit unit;
    unit.name = name;
    unit.program = plan.facts.programs + "/" + program;
    unit.log = plan.run_folder + "/" + name + ".log";
    unit.environment["OOS_RUN"] = options_.run;  // identifies processes that are left over from a run
    if (!plan.host.cache.empty()) unit.environment["VR_OOS_CACHE"] = plan.host.cache;
    return unit;
  }

  static void Add(Unit* unit, const std::string& name, const std::string& value) {
    unit->arguments.push_back(name);
    unit->arguments.push_back(value);
  }

  void AddSession(const HostPlan& plan, Unit* unit) const {
    Add(unit, "--registry", plan_.registry);
    Add(unit, "--session", std::to_string(options_.session));
    if (options_.has_keys) {
      Add(unit, "--keys", KeyFolder(plan.facts));
    } else {
      unit->arguments.push_back("--no_encryption");
    }
  }

  void AddRegistry(HostPlan* plan) const {
    Unit unit = NewUnit(*plan, "registry", "oos");
    unit.arguments = {"registry"};
    AddSession(*plan, &unit);
    plan->units.push_back(std::move(unit));
    if (!options_.is_recorded) return;
    Unit recorder = NewUnit(*plan, "recorder", "oos");
    recorder.arguments = {"record", plan->run_folder + "/run.mcap", "--next"};
    AddSession(*plan, &recorder);
    plan->units.push_back(std::move(recorder));
  }

  void AddNode(const Placement& placement, HostPlan* plan) const {
    const bool is_pair = lab_.is_colocated && placement.node == "haptic_node";
    const std::string program = is_pair ? kColocatedProgram : placement.node;
    const bool is_traced = lab_.traces_rays() && placement.node == "visual_node";
    Unit unit = NewUnit(*plan, program, is_traced ? kRayViewerProgram : program);
    unit.nodes = {placement.node};
    if (is_pair) unit.nodes.push_back("physics_node");
    Add(&unit, "--scenario", plan->facts.scenario);
    AddSession(*plan, &unit);
    Add(&unit, "--bind", plan->facts.bind);
    Add(&unit, "--out", plan->run_folder);
    unit.cores = placement.cores;
    const bool writes_latest = placement.node != "visual_node";
    if (writes_latest && !lab_.tcp_topics.empty()) Add(&unit, "--tcp_topics", lab_.tcp_topics);
    if (writes_latest && !lab_.multicast.empty()) Add(&unit, "--multicast", lab_.multicast);
    if (placement.node == "device_bridge") {
      Add(&unit, "--seed", std::to_string(options_.seed));
      for (const DeviceAccess& device : placement.devices) {
        if (device.type.empty()) continue;
        Add(&unit, "--device", device.role + "=" + device.type + (device.address.empty() ? "" : ":" + device.address));
      }
    }
    if (placement.node == "haptic_node" || placement.node == "physics_node") {
      Add(&unit, "--workers", std::to_string(options_.workers));
      Add(&unit, "--method", options_.method);
    }
    if (placement.node == "physics_node" || placement.node == "logic_node" || is_pair) {
      Add(&unit, "--resume", plan->run_folder);  // when the supervisor starts it again
    }
    if (placement.node == "logic_node") Add(&unit, "--patience_s", std::to_string(kComebackPatience_s));
    if (placement.node != "visual_node" && placement.node != "logic_node") Add(&unit, "--rt", placement.rt);
    const bool can_be_replayed = placement.node != "visual_node" && placement.node != "device_bridge";
    if (options_.records_steps && can_be_replayed) {
      const std::string folder = plan->run_folder + "/steps";
      Add(&unit, "--steps", is_pair ? folder : folder + "/" + placement.node + ".mcap");
    }
    if (placement.node == "visual_node") {
      unit.stop_patience_s = kViewerStopPatience_s;
      AddDisplay(placement.display, &unit, plan);
    }
    plan->units.push_back(std::move(unit));
  }

  // The seats of visual_node, in the lab file's order.
  void AddRayWorkers(HostPlan* plan) const {
    const bool is_out =
        std::find(options_.without.begin(), options_.without.end(), "visual_node") != options_.without.end();
    std::size_t seat = 0;
    for (const RayWorkers& workers : lab_.ray_workers) {
      for (std::size_t i = 0; i < workers.count; ++i) {
        const std::string name = tiles::WorkerName("visual_node", ++seat);
        if (workers.host == plan->host.name && !is_out) AddRayWorker(name, plan);
      }
    }
  }

  void AddRayWorker(const std::string& name, HostPlan* plan) const {
    Unit unit = NewUnit(*plan, name, kRayWorkerProgram);
    Add(&unit, "--scenario", plan->facts.scenario);
    AddSession(*plan, &unit);
    Add(&unit, "--bind", plan->facts.bind);
    Add(&unit, "--out", plan->run_folder);
    Add(&unit, "--name", name);
    plan->units.push_back(std::move(unit));
  }

  Unit NewViewer(const Viewer& viewer, HostPlan* plan) const {
    const std::string name = "visual_node-" + viewer.name;
    Unit unit = NewUnit(*plan, name, ProgramOf(viewer.renderer));
    unit.nodes = {name};
    unit.stop_patience_s = kViewerStopPatience_s;
    Add(&unit, "--name", name);
    Add(&unit, "--scenario", plan->facts.scenario);
    AddSession(*plan, &unit);
    Add(&unit, "--bind", plan->facts.bind);
    Add(&unit, "--out", plan->run_folder + "/" + name);
    for (const std::string& argument : ViewerArguments(viewer)) unit.arguments.push_back(argument);
    AddDisplay(viewer.display, &unit, plan);
    if (viewer.renderer == Renderer::kHeadset) std::erase(unit.arguments, "--headless");  // it has no window anyway
    return unit;
  }

  // The bridge starts scene_stream, which is the node.
  void AddPage(const Viewer& viewer, HostPlan* plan) const {
    Unit unit = NewUnit(*plan, "visual_node-" + viewer.name, "");
    unit.program = "/usr/bin/env";
    unit.arguments = {"node", plan->facts.page + "/tools/web_bridge/bridge.mjs", plan->facts.scenario};
    unit.nodes = {unit.name};
    unit.has_tools_key = true;
    unit.environment["OOS_STUBS"] = plan->facts.stubs;
    Add(&unit, "--registry", plan_.registry);
    Add(&unit, "--session", std::to_string(options_.session));
    if (options_.has_keys) Add(&unit, "--keys", KeyFolder(plan->facts));
    Add(&unit, "--name", unit.name);
    Add(&unit, "--bind", plan->facts.bind);
    Add(&unit, "--port", std::to_string(viewer.port));
    Add(&unit, "--programs", plan->facts.programs);
    if (!viewer.camera.empty()) Add(&unit, "--view", viewer.camera);
    plan->units.push_back(std::move(unit));
  }

  void AddViewer(const Viewer& viewer, Unit unit, HostPlan* plan) const {
    const std::string name = unit.name;
    plan->units.push_back(std::move(unit));
    for (std::size_t seat = 1; seat <= viewer.num_workers; ++seat) AddRayWorker(tiles::WorkerName(name, seat), plan);
  }

  void AddWalls(const Room& room, HostPlan* plan) const {
    for (const Wall& wall : room.walls) {
      if (wall.viewer.host != plan->host.name) continue;
      Unit unit = NewViewer(wall.viewer, plan);
      for (const std::string& argument : WallArguments(room, wall)) unit.arguments.push_back(argument);
      AddViewer(wall.viewer, std::move(unit), plan);
    }
  }

  [[nodiscard]] bool HasForceLoop(const std::string& host) const {
    return std::any_of(lab_.placements.begin(), lab_.placements.end(), [&](const Placement& placement) {
      return placement.host == host && placement.node != "logic_node" && placement.node != "visual_node";
    });
  }

  // Without a display, an X server without a screen is a unit of its own, listed first so that it ends last.
  static bool HasDisplay(const HostPlan& plan) {
    return std::any_of(plan.units.begin(), plan.units.end(), [](const Unit& unit) { return unit.name == "display"; });
  }
  void AddDisplay(const std::string& wanted, Unit* unit, HostPlan* plan) const {
    // A software renderer leaves the other cores to the force loop. A host without one has them all for drawing.
    if (HasForceLoop(plan->host.name)) unit->environment["LP_NUM_THREADS"] = "1";
    unit->environment["DISPLAY"] = wanted.empty() ? plan->facts.display : wanted;
    if (!wanted.empty()) return;
    unit->arguments.push_back("--headless");
    unit->socket = "/tmp/.X11-unix/X" + plan->facts.display.substr(1);
    if (HasDisplay(*plan)) return;
    Unit display = NewUnit(*plan, "display", "");
    display.program = "/usr/bin/Xvfb";
    display.arguments = {plan->facts.display, "-screen", "0", "1280x720x24", "-nolisten", "tcp", "-noreset"};
    plan->units.push_back(std::move(display));
  }

  const Lab& lab_;
  const std::map<std::string, HostFacts>& facts_;
  const PlanOptions& options_;
  Plan plan_;
};

}  // namespace

std::vector<std::string> ViewerArguments(const Viewer& viewer) {
  std::vector<std::string> arguments;
  const auto add_known = [&](const char* option, const std::string& value) {
    if (!value.empty()) arguments.insert(arguments.end(), {option, value});
  };
  add_known("--view", viewer.camera);
  add_known("--layout", viewer.layout);
  add_known("--stereo", viewer.stereo);
  add_known("--head", viewer.user);
  add_known("--size", viewer.size);
  return arguments;
}

std::vector<std::string> WallArguments(const Room& room, const Wall& wall) {
  std::string names, numbers;
  for (const Wall& each : room.walls) names += (names.empty() ? "" : ",") + each.viewer.name;
  for (const glm::dvec3& corner : {wall.screen_R.lower_left, wall.screen_R.lower_right, wall.screen_R.upper_left}) {
    char text[80];
    std::snprintf(text, sizeof text, "%.9g %.9g %.9g", corner.x, corner.y, corner.z);
    numbers += (numbers.empty() ? "" : " ") + std::string(text);
  }
  std::vector<std::string> arguments = {"--room",  room.name, "--wall",   wall.viewer.name,
                                        "--walls", names,     "--screen", numbers};
  if (!wall.place.empty()) arguments.insert(arguments.end(), {"--place", wall.place});
  if (room.eye_distance_m > 0.0) {
    char text[40];
    std::snprintf(text, sizeof text, "%.9g", 1e3 * room.eye_distance_m);
    arguments.insert(arguments.end(), {"--eye_distance_mm", text});
  }
  return arguments;
}

std::string KeyFolder(const HostFacts& facts) {
  return facts.root + "/keys";
}

std::string RegistryEndpoint(const Lab& lab, const std::map<std::string, HostFacts>& facts) {
  return "tcp://" + facts.at(lab.registry_host).bind + ":" + std::to_string(lab.registry_port);
}

Plan MakePlan(const Lab& lab, const std::map<std::string, HostFacts>& facts, const PlanOptions& options) {
  return Planner(lab, facts, options).Make();
}

std::string Describe(const Plan& plan) {
  std::string text = "run " + plan.run + ", registry at " + plan.registry + "\n";
  for (const HostPlan& host : plan.hosts) {
    text += host.host.name + " (" + (host.host.user.empty() ? "" : host.host.user + "@") + host.host.address + ", " +
            (host.host.supervisor == SupervisorKind::kSystemd ? "systemd" : "supervisor") + "), in " + host.run_folder +
            "\n";
    for (const Unit& unit : host.units) {
      text += "  " + unit.name + ":";
      if (!unit.cores.empty()) text += " on cores " + unit.cores + ":";
      text += " " + unit.program;
      for (const std::string& argument : unit.arguments) {
        text += argument.find(' ') == std::string::npos ? " " + argument : " '" + argument + "'";
      }
      text += "\n";
    }
  }
  return text;
}

}  // namespace lab
