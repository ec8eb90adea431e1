#include "tools/oos/launch/keys.hpp"

#include <fstream>
#include <iterator>
#include <set>

#include "bus/security/keys.hpp"
#include "lab/lab.hpp"
#include "tiles/seats.hpp"

namespace oos {

LaunchKeys::~LaunchKeys() {
  std::error_code error;
  if (!directory_.empty()) std::filesystem::remove_all(directory_, error);
}

core::Result<void> LaunchKeys::Make(const std::filesystem::path& directory) {
  std::vector<std::string> names(std::begin(lab::kNodeNames), std::end(lab::kNodeNames));
  names.insert(names.end(), {lab::kRayWorkerProgram, "oos", "client"});
  std::error_code error;
  std::filesystem::create_directories(directory.parent_path(), error);
  directory_ = directory;
  std::filesystem::remove_all(directory_, error);
  return bus::MakeKeys(directory_, names);
}

core::Result<std::string> LaunchKeys::ScriptFor(const lab::HostPlan& plan) const {
  std::set<std::string> files = {"allowed"};
  for (const lab::Unit& unit : plan.units) {
    if (unit.name == "display") continue;
    const bool is_tool = unit.name == "registry" || unit.name == "recorder";
    if (is_tool || unit.has_tools_key) files.insert("oos.key");
    // For observers on other machines (lab_session.hpp).
    if (unit.name == "registry") files.insert({"visual_node.key", "client.key"});
    if (unit.name == "registry") files.insert("registry.key");
    // visual_node-left has visual_node's key.
    for (const std::string& node : unit.nodes) files.insert(node.substr(0, node.find('-')) + ".key");
    if (tiles::ReadWorkerName(unit.name)) files.insert(std::string(lab::kRayWorkerProgram) + ".key");
  }
  const std::string folder = lab::KeyFolder(plan.facts);
  std::string script = "umask 077\nrm -rf " + folder + "\nmkdir -p " + folder + " && cd " + folder + " || exit 1\n";
  for (const std::string& name : files) {
    std::ifstream in(directory_ / name);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    if (text.empty()) return core::Fail(core::ErrorCode::kIo, "cannot read " + (directory_ / name).string());
    script += "cat >" + name + " <<'END_OF_KEY'\n" + text + (text.back() == '\n' ? "" : "\n") + "END_OF_KEY\n";
  }
  return script;
}

}  // namespace oos
