#include "tools/oos/check/check_scenario.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <string>

#include "core/names.hpp"
#include "lab/lab.hpp"
#include "nodes/device_bridge/operator/operator_script.hpp"
#include "nodes/logic_node/procedure.hpp"
#include "scene/load_scenario.hpp"
#include "vps/mesh/check_mesh.hpp"
#include "vps/mesh/load_mesh.hpp"
#include "vps/mesh/part_size.hpp"

namespace oos {
namespace {

// Checks the mesh as cooking does; returns its bounding box.
core::Result<vps::Box> CheckCollisionMesh(const scene::Object& object, CheckOutcome* outcome) {
  const auto checked = vps::LoadCheckedMesh(object.collision_mesh, 1.0, object.sheet_thickness_m > 0.0);
  if (!checked) return tl::unexpected(checked.error());
  for (const std::string& defect : vps::DescribeDefects(checked->report)) {
    outcome->notes.push_back("object '" + object.name + "': mesh " + object.collision_mesh.string() + ": " + defect);
  }
  return checked->report.box;
}

core::Result<vps::Box> CheckVisualMesh(const std::filesystem::path& file) {
  const auto mesh = vps::LoadMesh(file);
  if (!mesh) return tl::unexpected(mesh.error());
  return vps::BoundingBox(*mesh);
}

void CheckMeshes(const scene::Scenario& scenario, CheckOutcome* outcome) {
  std::set<std::filesystem::path> seen;
  std::map<std::string, vps::Box> collision_boxes;  // by file
  for (const scene::Object& object : scenario.objects) {
    for (const std::filesystem::path& file : {object.collision_mesh, object.visual_mesh}) {
      if (file.empty() || !seen.insert(file).second) continue;
      const auto box = file == object.collision_mesh ? CheckCollisionMesh(object, outcome) : CheckVisualMesh(file);
      const auto good = box ? vps::CheckPartSize(file.string(), *box) : core::Result<void>{};
      if (box && file == object.collision_mesh) collision_boxes[file.string()] = *box;
      if (box && good) continue;
      outcome->problems.push_back(scene::Format(
          {object.location, "object '" + object.name + "'", box ? good.error().detail : box.error().detail,
           "export the mesh again in metres (scaled by 0.001), or name another file"}));
    }
  }
  for (const scene::Pair& pair : scenario.pairs) {
    const std::string a = scenario.objects[pair.sampled].collision_mesh.string();
    const std::string b = scenario.objects[pair.field].collision_mesh.string();
    if (!collision_boxes.contains(a) || !collision_boxes.contains(b)) continue;
    const auto good = vps::CheckSameUnit(a, collision_boxes[a], b, collision_boxes[b]);
    if (!good) outcome->notes.push_back(good.error().detail);
  }
}

}  // namespace

CheckOutcome CheckScenario(const std::filesystem::path& path) {
  CheckOutcome outcome;
  const auto scenario = scene::LoadScenario(path);
  if (!scenario) {
    for (const scene::Diagnostic& diagnostic : scenario.error()) outcome.problems.push_back(scene::Format(diagnostic));
    return outcome;
  }
  outcome.scenario = *scenario;
  for (const auto& diagnostics :
       {logic_node::CheckProcedure(*scenario), device_bridge::CheckOperatorScript(*scenario)}) {
    for (const scene::Diagnostic& diagnostic : diagnostics) outcome.problems.push_back(scene::Format(diagnostic));
  }
  CheckMeshes(*scenario, &outcome);
  return outcome;
}

core::Result<void> CheckNodeNames(const std::vector<std::string>& names) {
  const std::vector<std::string> known(std::begin(lab::kNodeNames), std::end(lab::kNodeNames));
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "--without: there is no node '" + name + "'; " + core::SuggestName(name, known));
  }
  return {};
}

}  // namespace oos
