#pragma once

#include "core/result.hpp"
#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// Of a solid of uniform density that fills the mesh.
struct MassProperties {
  double mass_kg = 0.0;
  double volume_m3 = 0.0;
  glm::dvec3 p_OCom_m{0.0};           // centre of mass in the mesh frame O
  glm::dmat3 inertia_Com_kg_m2{0.0};  // about the centre of mass, axes of the mesh frame
};

// Exact for a closed mesh, by the divergence theorem. Errors: open or inconsistently oriented mesh, inside-out mesh,
// density not positive.
core::Result<MassProperties> ComputeMassProperties(const TriangleMesh& mesh, double density_kg_per_m3);

}  // namespace vps
