#include "tools/oos/check_scenario.hpp"

#include <algorithm>
#include <cstdio>
#include <set>
#include <string>

#include "nodes/device_bridge/operator_script.hpp"
#include "nodes/logic_node/procedure.hpp"
#include "scene/load_scenario.hpp"
#include "vps/mesh/load_mesh.hpp"

namespace oos {
namespace {

// Sides of a box around a part that a hand can have to do with. A mesh outside was most likely drawn in another unit.
constexpr double kSmallestPart_m = 0.0005;
constexpr double kLargestPart_m = 20.0;

void CheckSize(const scene::Object& object, const std::filesystem::path& file, const vps::TriangleMesh& mesh,
               std::vector<std::string>* problems) {
  const vps::Box box = vps::BoundingBox(mesh);
  const glm::dvec3 size_m = box.upper - box.lower;
  const double longest_m = std::max({size_m.x, size_m.y, size_m.z});
  if (longest_m >= kSmallestPart_m && longest_m <= kLargestPart_m) return;
  char why[160];
  std::snprintf(why, sizeof why, "its longest side is %g m, a part has %g to %g m: wrong unit?", longest_m,
                kSmallestPart_m, kLargestPart_m);
  problems->push_back(scene::Format({object.location, "object '" + object.name + "': mesh " + file.string(), why,
                                     "export it in metres, e.g. a drawing in millimetres scaled by 0.001"}));
}

void CheckMeshes(const scene::Scenario& scenario, std::vector<std::string>* problems) {
  std::set<std::filesystem::path> seen;
  for (const scene::Object& object : scenario.objects) {
    for (const std::filesystem::path& mesh : {object.visual_mesh, object.collision_mesh}) {
      if (mesh.empty() || !seen.insert(mesh).second) continue;
      const auto loaded = vps::LoadMesh(mesh);
      if (loaded) {
        CheckSize(object, mesh, *loaded, problems);
        continue;
      }
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
