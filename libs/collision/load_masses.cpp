#include "collision/load_masses.hpp"

#include "vps/mesh/check_mesh.hpp"
#include "vps/mesh/load_mesh.hpp"
#include "vps/mesh/mass_properties.hpp"
#include "vps/mesh/thicken_sheet.hpp"

namespace collision {
namespace {

// Mass properties of the mesh's bounding box; each side at least 1 mm, so that a sheet has an inertia about every axis.
physics::MassProperties BoundingBoxMass(const vps::TriangleMesh& mesh, double mass_kg) {
  glm::dvec3 low(1e30);
  glm::dvec3 high(-1e30);
  for (const auto& vertex : mesh.vertices) {
    low = glm::min(low, glm::dvec3(vertex));
    high = glm::max(high, glm::dvec3(vertex));
  }
  physics::MassProperties mass = physics::BoxMass(mass_kg, glm::max(high - low, glm::dvec3(1e-3)));
  mass.p_OCm_m = 0.5 * (low + high);
  return mass;
}

// The boundary of the object's volume. A mesh that bounds no volume is returned unchanged.
core::Result<vps::TriangleMesh> LoadSolid(const std::filesystem::path& file, double sheet_thickness_m) {
  const auto checked = vps::LoadCheckedMesh(file, 1.0, sheet_thickness_m > 0.0);
  if (!checked) return vps::LoadMesh(file);
  return sheet_thickness_m > 0.0 ? vps::ThickenSheet(checked->mesh, sheet_thickness_m) : checked->mesh;
}

}  // namespace

core::Result<std::vector<physics::MassProperties>> LoadMasses(const scene::Scenario& scenario) {
  std::vector<physics::MassProperties> masses(scenario.objects.size());
  for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
    const scene::Object& object = scenario.objects[i];
    if (object.owner != scene::Owner::kPhysics) continue;
    const std::string where =
        object.location.file.string() + ":" + std::to_string(object.location.line) + ": object '" + object.name + "': ";
    if (object.inertia) {
      masses[i] = {object.mass_kg, object.inertia->p_OCm_m, object.inertia->I_Cm_O_kg_m2};
      continue;
    }
    const auto& file = object.collision_mesh.empty() ? object.visual_mesh : object.collision_mesh;
    const auto mesh = LoadSolid(file, object.sheet_thickness_m);
    if (!mesh) return core::Fail(mesh.error().code, where + mesh.error().detail);
    const bool is_mass_given = object.mass_kg > 0.0;
    const auto solid = vps::ComputeMassProperties(*mesh, is_mass_given ? 1000.0 : object.density_kg_per_m3);
    if (!solid) {
      if (!is_mass_given) {
        return core::Fail(solid.error().code,
                          where + solid.error().detail + "; close the mesh, or give mass_kg instead of a density");
      }
      masses[i] = BoundingBoxMass(*mesh, object.mass_kg);
      continue;
    }
    const double scale = is_mass_given ? object.mass_kg / solid->mass_kg : 1.0;
    masses[i] = {scale * solid->mass_kg, solid->p_OCom_m, scale * solid->inertia_Com_kg_m2};
  }
  return masses;
}

}  // namespace collision
