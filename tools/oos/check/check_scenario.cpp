#include "tools/oos/check/check_scenario.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>
#include <string>

#include "collision/resolution/choose_resolutions.hpp"
#include "core/names.hpp"
#include "lab/lab.hpp"
#include "nodes/device_bridge/operator/operator_script.hpp"
#include "nodes/device_bridge/tactile/tactiles.hpp"
#include "nodes/logic_node/procedure.hpp"
#include "tools/oos/verb/find_scenario.hpp"
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

// What a viewer would refuse: a variant that the mesh file does not have, another number of joints.
void CheckLooks(const scene::Scenario& scenario, CheckOutcome* outcome) {
  const auto check = [&](const std::string& title, const std::filesystem::path& file, const std::string& variant,
                         std::size_t num_joints) {
    if (file.empty() || (variant.empty() && num_joints == 0)) return;
    const auto mesh = vps::LoadVisualMesh(file);
    if (!mesh) {
      outcome->problems.push_back(title + ": " + mesh.error().detail);
      return;
    }
    const auto& known = mesh->variants;
    if (!variant.empty() && std::find(known.begin(), known.end(), variant) == known.end()) {
      outcome->problems.push_back(title + ": " + file.string() + " has no variant '" + variant + "'; " +
                                  core::SuggestName(variant, known));
    }
    if (num_joints > 0 && num_joints != mesh->joints.size()) {
      outcome->problems.push_back(title + ": the skin of " + file.string() + " has " +
                                  std::to_string(mesh->joints.size()) + " joints, and " + std::to_string(num_joints) +
                                  " are named; name what each goes with, in the file's order");
    }
  };
  for (const scene::Object& object : scenario.objects) {
    check("object '" + object.name + "'", object.visual_mesh, object.material.variant, 0);
  }
  for (const scene::Scenery& scenery : scenario.scenery) {
    check("scenery '" + scenery.name + "'", scenery.mesh, scenery.variant, scenery.joints.size());
  }
}

}  // namespace

CheckOutcome CheckScenario(const std::filesystem::path& path) {
  CheckOutcome outcome;
  std::error_code error;
  if (!path.has_parent_path() && !path.has_extension() && !std::filesystem::exists(path, error)) {
    outcome.problems.push_back("no scenario '" + path.string() + "': no such file or folder, and none of that name; " +
                               core::SuggestName(path.string(), KnownScenarios()));
    return outcome;
  }
  const auto scenario = collision::LoadResolvedScenario(path);
  if (!scenario) {
    for (const scene::Diagnostic& diagnostic : scenario.error()) outcome.problems.push_back(scene::Format(diagnostic));
    return outcome;
  }
  outcome.scenario = *scenario;
  for (const auto& diagnostics : {logic_node::CheckProcedure(*scenario), device_bridge::CheckOperatorScript(*scenario),
                                  device_bridge::CheckTactiles(*scenario)}) {
    for (const scene::Diagnostic& diagnostic : diagnostics) outcome.problems.push_back(scene::Format(diagnostic));
  }
  CheckMeshes(*scenario, &outcome);
  CheckLooks(*scenario, &outcome);
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
