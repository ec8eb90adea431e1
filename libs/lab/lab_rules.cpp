#include "lab/lab_rules.hpp"

#include "lab/lab.hpp"
#include "view/stereo.hpp"

namespace lab {
namespace {

using scene::ValueKind;

scene::AttributeRule Optional(const char* name, ValueKind kind) {
  return {name, kind, false, {}};
}
scene::AttributeRule Required(const char* name, ValueKind kind) {
  return {name, kind, true, {}};
}

scene::AttributeRule Stereo() {
  std::vector<std::string> modes;
  for (const view::StereoInfo& info : view::kStereoModes) modes.emplace_back(info.name);
  return {"stereo", ValueKind::kChoice, false, std::move(modes)};
}

scene::AttributeRule RendererOf() {
  std::vector<std::string> names;
  for (const RendererInfo& info : kRenderers) names.emplace_back(info.name);
  return {"renderer", ValueKind::kChoice, false, std::move(names)};
}

}  // namespace

const std::vector<scene::ElementRule>& LabRules() {
  static const std::vector<scene::ElementRule> rules = {
      {"lab",
       "machines and what runs on each",
       {Required("name", ValueKind::kName),
        Optional("max_clock_bound_ms", ValueKind::kPositive),
        Optional("min_free_MB", ValueKind::kNonNegative),
        Optional("tcp_topics", ValueKind::kText),
        Optional("multicast", ValueKind::kText),
        {"colocate", ValueKind::kChoice, false, {kColocate}}},
       {{"host", 1, 0}, {"registry", 1, 1}, {"node", 1, 0}, {"ray_workers", 0, 0}, {"view", 0, 0}, {"room", 0, 0}}},
      {"host",
       "a machine that ssh reaches",
       {Required("name", ValueKind::kName),
        Required("address", ValueKind::kName),
        Optional("user", ValueKind::kName),
        Optional("port", ValueKind::kCount),
        Optional("ssh_config", ValueKind::kFile),
        Optional("identity", ValueKind::kFile),
        Optional("bind", ValueKind::kName),
        Optional("run_folder", ValueKind::kText),
        Optional("programs", ValueKind::kText),
        Optional("cache", ValueKind::kText),
        {"supervisor", ValueKind::kChoice, false, {"supervisor", "systemd"}}},
       {}},
      {"registry",
       "where the nodes find each other",
       {Required("host", ValueKind::kName), Optional("port", ValueKind::kCount)},
       {}},
      {"node",
       "a node and the host that runs it",
       {{"name",
         ValueKind::kChoice,
         true,
         {"physics_node", "haptic_node", "logic_node", "visual_node", "device_bridge"}},
        Required("host", ValueKind::kName),
        {"rt", ValueKind::kChoice, false, {"off", "try", "enforce"}},
        Optional("cores", ValueKind::kText),
        Optional("display", ValueKind::kText)},
       {{"device", 0, 0}}},
      {"ray_workers",
       "workers that trace the pictures of visual_node",
       {Required("host", ValueKind::kName), Optional("count", ValueKind::kCount)},
       {}},
      {"view",
       "another viewer of the run: of a camera, or several in a layout",
       {Required("name", ValueKind::kName), Required("host", ValueKind::kName), Optional("camera", ValueKind::kName),
        Optional("layout", ValueKind::kText), Stereo(), Optional("user", ValueKind::kName),
        Optional("size", ValueKind::kText), Optional("display", ValueKind::kText), RendererOf(),
        Optional("workers", ValueKind::kCount), Optional("port", ValueKind::kCount)},
       {}},
      {"room",
       "walls around a person, each a window onto the scene, in step",
       {Required("name", ValueKind::kName), Optional("camera", ValueKind::kName), Stereo(),
        Optional("user", ValueKind::kName), Optional("eye_distance_mm", ValueKind::kPositive)},
       {{"screen", 1, 0}}},
      {"screen",
       "a wall: its corners in metres from the room's viewpoint, x to the right, y ahead, z up; the first one leads",
       {Required("name", ValueKind::kName), Required("host", ValueKind::kName),
        Required("lower_left", ValueKind::kVector), Required("lower_right", ValueKind::kVector),
        Required("upper_left", ValueKind::kVector), Required("size", ValueKind::kText),
        Optional("place", ValueKind::kText), Optional("display", ValueKind::kText), RendererOf(),
        Optional("workers", ValueKind::kCount)},
       {}},
      {"device",
       "a role's device on that host: type and address in place of the scenario's, a file that must be there and open",
       {Required("role", ValueKind::kName),
        {"type", ValueKind::kChoice, false, {std::begin(scene::kDeviceTypes), std::end(scene::kDeviceTypes)}},
        Optional("address", ValueKind::kText),
        Optional("path", ValueKind::kText)},
       {}},
  };
  return rules;
}

}  // namespace lab
