#include "lab/load_lab.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <string_view>

#include "core/names.hpp"
#include "lab/lab_rules.hpp"
#include "scene/element_reader.hpp"
#include "scene/xml.hpp"
#include "tiles/seats.hpp"

namespace lab {
namespace {

using scene::Diagnostic;

constexpr char kPlainCharacters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789/._+@:-";

class Reader {
 public:
  Reader(const std::filesystem::path& file, std::vector<Diagnostic>* diagnostics) : diagnostics_(diagnostics) {
    std::error_code error;
    lab_.file = std::filesystem::absolute(file, error).lexically_normal();
  }

  Lab Read(const scene::XmlElement& root) {
    lab_.name = root.Get("name");
    scene::ParseNumber(root.Get("max_clock_bound_ms"), &lab_.max_clock_bound_ms);
    scene::ParseNumber(root.Get("min_free_MB"), &lab_.min_free_MB);
    ReadNetwork(root);
    lab_.is_colocated = root.Get("colocate") == kColocate;
    for (const scene::XmlElement& element : root.children) {
      if (element.name == "host") ReadHost(element);
    }
    for (const scene::XmlElement& element : root.children) {
      if (element.name == "registry") {
        lab_.registry_host = element.Get("host");
        ReadPort(element, &lab_.registry_port);
        CheckHost(element, "registry");
      }
      if (element.name == "node") ReadNode(element);
      if (element.name == "ray_workers") ReadRayWorkers(element);
      if (element.name == "view") ReadView(element);
      if (element.name == "room") ReadRoom(element);
    }
    if (lab_.is_colocated) CheckPair(root);
    return std::move(lab_);
  }

 private:
  void Report(int line, std::string what, std::string why, std::string fix) {
    diagnostics_->push_back({{lab_.file, line}, std::move(what), std::move(why), std::move(fix)});
  }

  void ReadNetwork(const scene::XmlElement& root) {
    lab_.tcp_topics = root.Get("tcp_topics");
    const std::string pattern_characters = std::string(kPlainCharacters) + "*,";
    if (lab_.tcp_topics.find_first_not_of(pattern_characters) != std::string::npos) {
      Report(root.LineOf("tcp_topics"), "tcp_topics is '" + lab_.tcp_topics + "'",
             "it becomes part of the nodes' commands",
             "write patterns with commas between them, such as physics/*,contacts/*");
    }
    lab_.multicast = root.Get("multicast");
    in_addr group{};
    const std::size_t colon = std::min(lab_.multicast.find(':'), lab_.multicast.size());
    std::uint64_t port = 0;
    const bool is_group = inet_pton(AF_INET, lab_.multicast.substr(0, colon).c_str(), &group) == 1 &&
                          IN_MULTICAST(ntohl(group.s_addr)) && colon < lab_.multicast.size() &&
                          scene::ParseCount(lab_.multicast.substr(colon + 1), &port) && port >= 1 && port <= 65535;
    if (!lab_.multicast.empty() && !is_group) {
      Report(root.LineOf("multicast"), "multicast is '" + lab_.multicast + "'",
             "it must be a group from 224.0.0.0 to 239.255.255.255 and a port",
             "write for instance 239.255.74.50:7450");
    }
  }

  void ReadPort(const scene::XmlElement& element, std::uint16_t* port) {
    std::uint64_t value = 0;
    if (element.Find("port") == nullptr || !scene::ParseCount(element.Get("port"), &value)) return;
    if (value < 1 || value > 65535) {
      Report(element.LineOf("port"), element.name + ": port is " + element.Get("port"), "ports are from 1 to 65535",
             "choose a number in that range");
      return;
    }
    *port = static_cast<std::uint16_t>(value);
  }

  std::filesystem::path FileIn(const scene::XmlElement& element, const char* attribute) {
    const std::string text = element.Get(attribute);
    if (text.empty()) return {};
    std::filesystem::path file = (lab_.file.parent_path() / text).lexically_normal();
    if (!std::filesystem::is_regular_file(file)) {
      Report(element.LineOf(attribute),
             "host '" + element.Get("name") + "': " + attribute + " '" + text + "' is not a file",
             "ssh would not find it", "give its path, absolute or relative to the lab file's folder");
    }
    return file;
  }

  void ReadHost(const scene::XmlElement& element) {
    Host host;
    host.where = {lab_.file, element.line};
    host.name = element.Get("name");
    host.address = element.Get("address");
    host.user = element.Get("user");
    host.bind = element.Get("bind");
    host.run_folder = element.Get("run_folder", host.run_folder);
    host.programs = element.Get("programs");
    host.cache = element.Get("cache");
    host.supervisor = element.Get("supervisor") == "systemd" ? SupervisorKind::kSystemd : SupervisorKind::kSupervisor;
    host.ssh_config = FileIn(element, "ssh_config");
    host.identity = FileIn(element, "identity");
    ReadPort(element, &host.ssh_port);
    for (const char* option : {"name", "address", "user"}) {
      if (element.Get(option).rfind('-', 0) == 0) {
        Report(element.LineOf(option), "host: " + std::string(option) + " is '" + element.Get(option) + "'",
               "ssh would take it for an option", "let it begin with a letter or a digit");
      }
    }
    for (const char* attribute : {"name", "address", "user", "bind", "run_folder", "programs", "cache"}) {
      const std::string text = element.Get(attribute);
      if (text.rfind('-', 0) != 0 && text.find_first_not_of(kPlainCharacters) != std::string::npos) {
        Report(element.LineOf(attribute), "host '" + host.name + "': " + attribute + " is '" + text + "'",
               "it becomes part of commands and unit files", "use only letters, digits and / . _ + @ : -");
      }
    }
    for (const char* folder : {"programs", "cache"}) {
      if (const std::string text = element.Get(folder); !text.empty() && text.front() != '/') {
        Report(element.LineOf(folder), "host '" + host.name + "': " + folder + " is '" + text + "'",
               "a relative folder would depend on the user's home on that host", "write an absolute path");
      }
    }
    if (const Host* first = lab_.FindHost(host.name)) {
      Report(element.LineOf("name"), "host '" + host.name + "' is declared twice",
             "the first is in line " + std::to_string(first->where.line), "rename or remove one");
      return;
    }
    lab_.hosts.push_back(std::move(host));
  }

  void CheckHost(const scene::XmlElement& element, const std::string& title) {
    const std::string name = element.Get("host");
    if (name.empty() || lab_.FindHost(name) != nullptr) return;
    std::vector<std::string> known;
    for (const Host& host : lab_.hosts) known.push_back(host.name);
    Report(element.LineOf("host"), title + ": unknown host '" + name + "'", "the file has no <host> of that name",
           core::SuggestName(name, known));
  }

  void CheckDevice(const scene::XmlElement& element, const DeviceAccess& device) {
    if (device.type.empty() && device.path.empty()) {
      Report(element.line, "device of role '" + device.role + "' with neither type nor path", "it would say nothing",
             "write type and address, as type=\"udp\" address=\"7460\", or the path of a file that must be open");
    }
    const bool needs_address = !device.type.empty() && device.type.rfind("simulated_", 0) != 0;
    if (needs_address != !device.address.empty()) {
      Report(
          element.line, "device of role '" + device.role + "': " + (needs_address ? "no address" : "an address"),
          needs_address ? "the bridge would not know where the device is" : "only a type other than simulated has one",
          needs_address ? "write address=\"...\", docs/howto/own-device.md says what" : "remove address");
    }
    if (device.address.find_first_not_of(kPlainCharacters) != std::string::npos) {
      Report(element.LineOf("address"), "device address '" + device.address + "'", "it becomes part of a command",
             "use only letters, digits and / . _ + @ : -");
    }
  }

  void ReadNode(const scene::XmlElement& element) {
    Placement node;
    node.where = {lab_.file, element.line};
    node.node = element.Get("name");
    node.host = element.Get("host");
    node.rt = element.Get("rt", node.rt);
    node.cores = element.Get("cores");
    node.display = element.Get("display");
    CheckHost(element, node.node);
    if (node.cores.find_first_not_of("0123456789,-") != std::string::npos) {
      Report(element.LineOf("cores"), node.node + ": cores is '" + node.cores + "'", "it is a list of CPU numbers",
             "write for instance 2,3 or 2-5");
    }
    if (!node.display.empty() && node.node != "visual_node") {
      Report(element.LineOf("display"), node.node + " has a display", "only visual_node draws", "remove it");
    }
    for (const scene::XmlElement& device : element.children) {
      node.devices.push_back({device.Get("role"),
                              device.Get("path"),
                              device.Get("type"),
                              device.Get("address"),
                              {lab_.file, device.line}});
      CheckDevice(device, node.devices.back());
      const std::string& path = node.devices.back().path;
      if (path.empty()) continue;
      if (path.find_first_not_of(kPlainCharacters) != std::string::npos || path.rfind('/', 0) != 0) {
        Report(device.LineOf("path"), "device path '" + path + "'", "it names a file of that host",
               "write an absolute path of letters, digits and / . _ + @ : -, such as /dev/hidraw0");
      }
    }
    if (!node.devices.empty() && node.node != "device_bridge") {
      Report(element.children.front().line, node.node + " has a <device>", "only device_bridge opens devices",
             "move it to device_bridge");
    }
    if (const Placement* first = lab_.FindPlacement(node.node)) {
      const std::string fix = first->host == node.host ? "remove one" : "choose " + first->host + " or " + node.host;
      Report(element.line, node.node + " is placed twice, on " + first->host + " and on " + node.host,
             "its topics have one writer (the first placement is in line " + std::to_string(first->where.line) + ")",
             fix);
      return;
    }
    lab_.placements.push_back(std::move(node));
  }

  void ReadRayWorkers(const scene::XmlElement& element) {
    RayWorkers workers{element.Get("host"), 1, {lab_.file, element.line}};
    CheckHost(element, "ray_workers");
    std::uint64_t count = 1;
    if (element.Find("count") != nullptr) scene::ParseCount(element.Get("count"), &count);
    workers.count = static_cast<std::size_t>(count);
    std::size_t all = workers.count;
    for (const RayWorkers& others : lab_.ray_workers) all += others.count;
    if (count < 1 || all > tiles::kMostSeats) {
      Report(element.LineOf("count"), "ray_workers: " + std::to_string(all) + " in all",
             "a viewer has seats for 1 to " + std::to_string(tiles::kMostSeats), "place fewer");
    }
    lab_.ray_workers.push_back(std::move(workers));
  }

  // "1280x720", "0,40": two whole numbers.
  void CheckNumbers(const scene::XmlElement& element, const char* attribute, char separator, const char* example) {
    const std::string text = element.Get(attribute);
    if (text.empty()) return;
    const std::size_t at = std::min(text.find(separator), text.size());
    std::uint64_t numbers[2] = {};
    if (scene::ParseCount(text.substr(0, at), &numbers[0]) && at < text.size() &&
        scene::ParseCount(text.substr(at + 1), &numbers[1])) {
      return;
    }
    Report(element.LineOf(attribute),
           element.name + " '" + element.Get("name") + "': " + attribute + " is '" + text + "'",
           "it is two whole numbers of pixels", std::string("write for instance ") + example);
  }

  // What a view has in common with a wall. Its node is visual_node-<name>.
  Viewer ReadViewer(const scene::XmlElement& element) {
    Viewer viewer;
    viewer.where = {lab_.file, element.line};
    viewer.name = element.Get("name");
    viewer.host = element.Get("host");
    viewer.display = element.Get("display");
    viewer.size = element.Get("size");
    ReadRenderer(element, &viewer);
    CheckHost(element, element.name + " '" + viewer.name + "'");
    CheckNumbers(element, "size", 'x', "1280x720");
    CheckPlain(element, "display");
    for (const Viewer* other : lab_.ViewersOn("")) {
      if (other->name != viewer.name) continue;
      Report(element.LineOf("name"), "a second viewer '" + viewer.name + "'",
             "its node has that name, as that of line " + std::to_string(other->where.line), "rename one of them");
    }
    return viewer;
  }

  void ReadRenderer(const scene::XmlElement& element, Viewer* viewer) {
    const std::string title = element.name + " '" + viewer->name + "'";
    const std::string name = element.Get("renderer", kRenderers[0].name);
    for (const RendererInfo& info : kRenderers) {
      if (name == info.name) viewer->renderer = info.renderer;
    }
    const bool is_traced = viewer->renderer == Renderer::kRays;
    std::uint64_t workers = is_traced ? 1 : 0;
    if (element.Find("workers") != nullptr) scene::ParseCount(element.Get("workers"), &workers);
    viewer->num_workers = static_cast<std::size_t>(workers);
    if (is_traced != (workers > 0) || workers > tiles::kMostSeats) {
      Report(element.LineOf("workers"), title + ": " + std::to_string(workers) + " workers",
             "those of renderer=\"rays\" are 1 to " + std::to_string(tiles::kMostSeats) + ", and others have none",
             is_traced ? "write another number" : "remove workers, or write renderer=\"rays\"");
    }
    const bool is_worn = viewer->renderer == Renderer::kHeadset;
    for (const char* attribute : {"layout", "stereo", "user", "size", "lower_left"}) {
      if (!is_worn || element.Find(attribute) == nullptr) continue;
      Report(element.LineOf(attribute), title + " in a headset has " + attribute,
             "the headset itself says where its eyes are and what they see", "remove it, or the renderer");
    }
    ReadPage(element, viewer);
  }

  // Who opens the page says the rest.
  void ReadPage(const scene::XmlElement& element, Viewer* viewer) {
    const std::string title = element.name + " '" + viewer->name + "'";
    const bool is_page = viewer->renderer == Renderer::kPage;
    for (const char* attribute : {"layout", "stereo", "user", "size", "display", "lower_left"}) {
      if (!is_page || element.Find(attribute) == nullptr) continue;
      Report(element.LineOf(attribute), title + " is a page and has " + attribute,
             "a browser draws it, in a window of its own", "remove it, or the renderer");
    }
    if (!is_page && element.Find("port") != nullptr) {
      Report(element.LineOf("port"), title + " has a port", "only a page is served at one",
             "remove it, or write renderer=\"page\"");
    }
    if (!is_page) return;
    std::uint64_t port = kPagePort;
    if (element.Find("port") != nullptr) scene::ParseCount(element.Get("port"), &port);
    if (port < 1 || port > 65535) {
      Report(element.LineOf("port"), title + ": port is " + std::to_string(port), "ports are 1 to 65535",
             "write another number");
      return;
    }
    viewer->port = static_cast<std::uint16_t>(port);
    for (const Viewer* other : lab_.ViewersOn(viewer->host)) {
      if (other->port != viewer->port) continue;
      Report(element.line, title + " has port " + std::to_string(port),
             "it is that of view '" + other->name + "' on the same host", "give one of them another port");
    }
  }

  void CheckPlain(const scene::XmlElement& element, const char* attribute) {
    const std::string text = element.Get(attribute);
    if (text.find_first_not_of(kPlainCharacters) == std::string::npos) return;
    Report(element.LineOf(attribute),
           element.name + " '" + element.Get("name") + "': " + attribute + " is '" + text + "'",
           "it becomes part of commands and unit files", "use only letters, digits and / . _ + @ : -");
  }

  void ReadView(const scene::XmlElement& element) {
    Viewer viewer = ReadViewer(element);
    viewer.camera = element.Get("camera");
    viewer.layout = element.Get("layout");
    viewer.stereo = element.Get("stereo");
    viewer.user = element.Get("user");
    if (!viewer.camera.empty() && !viewer.layout.empty()) {
      Report(element.LineOf("layout"), "view '" + viewer.name + "' has a camera and a layout",
             "a layout names its cameras itself", "remove one of them");
    }
    const std::string layout_characters = std::string(kPlainCharacters) + " |*";
    if (viewer.layout.find_first_not_of(layout_characters) != std::string::npos) {
      Report(element.LineOf("layout"), "view '" + viewer.name + "': layout is '" + viewer.layout + "'",
             "it becomes part of the viewer's command",
             "write cameras' names with | between those side by side and / between rows, such as 'overview | gripper'");
    }
    lab_.viewers.push_back(std::move(viewer));
  }

  void ReadRoom(const scene::XmlElement& element) {
    Room room;
    room.name = element.Get("name");
    double eye_distance_mm = 0.0;
    scene::ParseNumber(element.Get("eye_distance_mm"), &eye_distance_mm);
    room.eye_distance_m = 1e-3 * eye_distance_mm;
    for (const Room& other : lab_.rooms) {
      if (other.name != room.name) continue;
      Report(element.LineOf("name"), "a second room '" + room.name + "'", "its walls keep in step by that name",
             "rename one of them");
    }
    lab_.rooms.push_back(room);
    for (const scene::XmlElement& child : element.children) {
      if (child.name != "screen") continue;
      Wall wall{ReadViewer(child), {}, child.Get("place")};
      wall.viewer.camera = element.Get("camera");
      wall.viewer.stereo = element.Get("stereo");
      wall.viewer.user = element.Get("user");
      const scene::ElementReader read(child);
      read.Vector("lower_left", &wall.screen_R.lower_left);
      read.Vector("lower_right", &wall.screen_R.lower_right);
      read.Vector("upper_left", &wall.screen_R.upper_left);
      CheckNumbers(child, "place", ',', "0,0");
      if (!view::CheckScreen(wall.screen_R)) {
        Report(child.line, "screen '" + wall.viewer.name + "': its corners are no rectangle",
               "from the lower left corner, the lower right and the upper left one are in directions at right angles",
               "measure them anew");
      }
      lab_.rooms.back().walls.push_back(std::move(wall));
    }
  }

  // One process has one host, one priority and one set of cores: those of haptic_node.
  void CheckPair(const scene::XmlElement& root) {
    const Placement* haptic = lab_.FindPlacement(kColocatedNodes[0]);
    const Placement* physics = lab_.FindPlacement(kColocatedNodes[1]);
    if (haptic == nullptr || physics == nullptr) return;  // CheckAgainst misses it
    if (physics->host != haptic->host) {
      Report(root.LineOf("colocate"), "haptic_node is on " + haptic->host + ", physics_node on " + physics->host,
             "colocate makes them one process", "place both on one host, or remove colocate");
    } else if (physics->cores != haptic->cores || physics->rt != haptic->rt) {
      Report(physics->where.line, "physics_node has other cores or another rt than haptic_node",
             "colocate makes them one process", "give both the same");
    }
  }

  Lab lab_;
  std::vector<Diagnostic>* diagnostics_;
};

}  // namespace

const Host* Lab::FindHost(const std::string& host_name) const {
  const auto it = std::find_if(hosts.begin(), hosts.end(), [&](const Host& host) { return host.name == host_name; });
  return it == hosts.end() ? nullptr : &*it;
}

const Placement* Lab::FindPlacement(const std::string& node) const {
  const auto it =
      std::find_if(placements.begin(), placements.end(), [&](const Placement& p) { return p.node == node; });
  return it == placements.end() ? nullptr : &*it;
}

std::vector<const Viewer*> Lab::ViewersOn(const std::string& host_name) const {
  std::vector<const Viewer*> found;
  const auto add = [&](const Viewer& viewer) {
    if (host_name.empty() || viewer.host == host_name) found.push_back(&viewer);
  };
  for (const Viewer& viewer : viewers) add(viewer);
  for (const Room& room : rooms) {
    for (const Wall& wall : room.walls) add(wall.viewer);
  }
  return found;
}

bool Lab::HasPageOn(const std::string& host_name) const {
  const auto on_host = ViewersOn(host_name);
  return std::any_of(on_host.begin(), on_host.end(),
                     [](const Viewer* viewer) { return viewer->renderer == Renderer::kPage; });
}

std::vector<std::string> Lab::ProgramsOfViewersOn(const std::string& host_name) const {
  std::vector<std::string> programs;
  const auto add = [&](const char* program) {
    if (std::find(programs.begin(), programs.end(), program) == programs.end()) programs.emplace_back(program);
  };
  for (const Viewer* viewer : ViewersOn(host_name)) {
    add(ProgramOf(viewer->renderer));
    if (viewer->num_workers > 0) add(kRayWorkerProgram);
  }
  return programs;
}

tl::expected<Lab, std::vector<Diagnostic>> LoadLab(const std::filesystem::path& file) {
  auto root = scene::ReadXml(file);
  if (!root) return tl::unexpected(root.error());
  std::vector<Diagnostic> diagnostics;
  scene::CheckAgainstRules(*root, file, &diagnostics, "lab", LabRules());
  if (root->name != "lab") return tl::unexpected(diagnostics);
  Lab lab = Reader(file, &diagnostics).Read(*root);
  if (diagnostics.empty()) return lab;
  std::stable_sort(diagnostics.begin(), diagnostics.end(),
                   [](const Diagnostic& a, const Diagnostic& b) { return a.where.line < b.where.line; });
  return tl::unexpected(std::move(diagnostics));
}

std::vector<Diagnostic> CheckAgainst(const Lab& lab, const scene::Scenario& scenario,
                                     const std::vector<std::string>& without) {
  std::vector<Diagnostic> diagnostics;
  std::vector<std::string> roles;
  for (const scene::Device& device : scenario.devices) roles.push_back(device.role);
  for (const char* node : kNodeNames) {
    const bool is_replaced = std::string_view(node) == "visual_node" && !lab.ViewersOn("").empty();
    if (is_replaced || lab.FindPlacement(node) != nullptr ||
        std::find(without.begin(), without.end(), node) != without.end())
      continue;
    diagnostics.push_back(
        {{lab.file, 1},
         std::string(node) + " is not placed on a host",
         "the scenario needs it",
         "add <node name=\"" + std::string(node) + "\" host=\"...\"/>, or leave it out with --without " + node});
  }
  for (const char* node : kColocatedNodes) {
    if (!lab.is_colocated || std::find(without.begin(), without.end(), node) == without.end()) continue;
    diagnostics.push_back({{lab.file, 1},
                           std::string(node) + " is left out, but colocated",
                           "colocate makes haptic_node and physics_node one process",
                           "remove colocate, or do not leave it out"});
  }
  for (const Placement& placement : lab.placements) {
    for (const DeviceAccess& device : placement.devices) {
      if (scenario.FindRole(device.role) >= 0) continue;
      diagnostics.push_back({device.where, "device of unknown role '" + device.role + "'",
                             "scenario " + scenario.name + " does not have it", core::SuggestName(device.role, roles)});
    }
  }
  std::vector<std::string> cameras, users;
  for (const scene::Camera& camera : scenario.cameras) cameras.push_back(camera.name);
  for (const scene::User& user : scenario.users) users.push_back(user.name);
  const auto check = [&](const Viewer& viewer, const std::string& name, const char* what,
                         const std::vector<std::string>& known) {
    if (name.empty() || std::find(known.begin(), known.end(), name) != known.end()) return;
    diagnostics.push_back({viewer.where, "viewer '" + viewer.name + "': unknown " + what + " '" + name + "'",
                           "scenario " + scenario.name + " does not have it", core::SuggestName(name, known)});
  };
  for (const Viewer* viewer : lab.ViewersOn("")) {
    check(*viewer, viewer->camera, "camera", cameras);
    check(*viewer, viewer->user, "user", users);
  }
  return diagnostics;
}

}  // namespace lab
