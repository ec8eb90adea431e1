#include "tools/oos/check_scenario.hpp"

#include <set>
#include <string>

#include "nodes/device_bridge/operator_script.hpp"
#include "nodes/logic_node/procedure.hpp"
#include "scene/load_scenario.hpp"
#include "vps/mesh/load_mesh.hpp"

namespace oos {
namespace {

void CheckMeshes(const scene::Scenario& scenario, std::vector<std::string>* problems) {
  std::set<std::filesystem::path> seen;
  for (const scene::Object& object : scenario.objects) {
    for (const std::filesystem::path& mesh : {object.visual_mesh, object.collision_mesh}) {
      if (mesh.empty() || !seen.insert(mesh).second) continue;
      const auto loaded = vps::LoadMesh(mesh);
      if (loaded) continue;
      problems->push_back(scene::Format({object.location, "object '" + object.name + "': mesh " + mesh.string(),
                                         loaded.error().detail, "export the mesh again, or name another file"}));
    }
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
  CheckMeshes(*scenario, &outcome.problems);
  return outcome;
}

}  // namespace oos
