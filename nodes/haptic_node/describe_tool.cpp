#include "nodes/haptic_node/describe_tool.hpp"

#include <vector>

#include "vps/mesh/check_mesh.hpp"
#include "vps/mesh/mass_properties.hpp"

namespace haptic_node {
namespace {

struct Part {
  vps::MassProperties solid;  // of density 1
  double mass_kg = 0.0;
  core::Pose X_CO;
};

std::vector<Part> PartsOf(const scene::Scenario& scenario, std::size_t role) {
  std::vector<Part> parts;
  for (const scene::Object& object : scenario.objects) {
    if (object.owner != scene::Owner::kHand || object.role != static_cast<int>(role)) continue;
    if (object.collision_mesh.empty()) continue;
    const auto checked = vps::LoadCheckedMesh(object.collision_mesh, 1.0, object.sheet_thickness_m > 0.0);
    if (!checked) continue;
    const auto solid = vps::ComputeMassProperties(checked->mesh, 1.0);
    if (!solid) continue;  // it bounds nothing: a sheet's share is none
    Part part;
    part.solid = *solid;
    part.mass_kg = object.mass_kg > 0.0 ? object.mass_kg : object.density_kg_per_m3 * solid->volume_m3;
    part.X_CO = scene::PartPose(object.part, {}, scenario.devices[role].opening_start_m);
    parts.push_back(part);
  }
  return parts;
}

}  // namespace

vps::GodObjectParameters DescribeTool(const scene::Scenario& scenario, std::size_t role, double radius_m) {
  vps::GodObjectParameters tool;
  tool.stiffness_N_per_m = scenario.coupling.stiffness_N_per_m;
  tool.stiffness_Nm_per_rad = scenario.coupling.stiffness_Nm_per_rad;
  const std::vector<Part> parts = PartsOf(scenario, role);
  double weight = 0.0;
  for (const Part& part : parts) tool.mass_kg += part.mass_kg;
  for (const Part& part : parts) {
    const double share = tool.mass_kg > 0.0 ? part.mass_kg : part.solid.volume_m3;
    weight += share;
    tool.p_CoCm_C += share * (part.X_CO * part.solid.p_OCom_m);
  }
  if (weight > 0.0) tool.p_CoCm_C /= weight;
  for (const Part& part : parts) {
    const glm::dmat3 R_CO = glm::mat3_cast(part.X_CO.rotation);
    const glm::dvec3 r = part.X_CO * part.solid.p_OCom_m - tool.p_CoCm_C;
    tool.I_Cm_C_kg_m2 +=
        part.mass_kg / part.solid.volume_m3 * R_CO * part.solid.inertia_Com_kg_m2 * glm::transpose(R_CO);
    tool.I_Cm_C_kg_m2 += part.mass_kg * (glm::dot(r, r) * glm::dmat3(1.0) - glm::outerProduct(r, r));
  }
  if (radius_m > 0.0) tool.bounding_radius_m = radius_m + glm::length(tool.p_CoCm_C);
  return tool;
}

}  // namespace haptic_node
