#include "vps/mesh/mass_properties.hpp"

#include <cmath>
#include <string>

namespace vps {

core::Result<MassProperties> ComputeMassProperties(const TriangleMesh& mesh, double density_kg_per_m3) {
  if (!(density_kg_per_m3 > 0.0) || !std::isfinite(density_kg_per_m3)) {
    return core::Fail(core::ErrorCode::kInvalidInput, "density must be a positive number of kg/m^3");
  }
  if (mesh.triangles.empty()) return core::Fail(core::ErrorCode::kInvalidInput, "the mesh has no triangles");
  const std::size_t num_open = CountOpenEdges(mesh);
  if (num_open != 0) {
    return core::Fail(
        core::ErrorCode::kInvalidInput,
        "the mesh does not enclose a volume: " + std::to_string(num_open) +
            " edges are open or have faces of opposite orientation; close the mesh or give mass and inertia");
  }
  // By the divergence theorem the integral over the solid is the signed sum over the tetrahedra (r, a, b, c) of its
  // triangles with any reference point r; the box centre keeps the terms small. For such a tetrahedron with
  // d = det[a b c] (six times its signed volume), taking a, b, c relative to r:
  //   integral dV      = d / 6
  //   integral x dV    = d / 24 (a + b + c)
  //   integral x x^T dV = d / 120 (s s^T + a a^T + b b^T + c c^T), s = a + b + c.
  const Box box = BoundingBox(mesh);
  const glm::dvec3 reference = 0.5 * (box.lower + box.upper);
  double volume = 0.0;
  glm::dvec3 first(0.0);
  glm::dmat3 second(0.0);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    auto [a, b, c] = mesh.corners(i);
    a -= reference;
    b -= reference;
    c -= reference;
    const double d = glm::dot(a, glm::cross(b, c));
    const glm::dvec3 s = a + b + c;
    volume += d / 6.0;
    first += d / 24.0 * s;
    second += d / 120.0 *
              (glm::outerProduct(s, s) + glm::outerProduct(a, a) + glm::outerProduct(b, b) + glm::outerProduct(c, c));
  }
  const glm::dvec3 size = box.upper - box.lower;
  const double scale = std::max({size.x, size.y, size.z});
  if (volume < -1e-12 * scale * scale * scale) {
    return core::Fail(core::ErrorCode::kInvalidInput, "the mesh is inside out: turn its faces over");
  }
  if (!(volume > 1e-12 * scale * scale * scale)) {
    return core::Fail(core::ErrorCode::kInvalidInput, "the mesh encloses no volume");
  }
  const glm::dvec3 centre = first / volume;
  const glm::dmat3 about_centre = second - volume * glm::outerProduct(centre, centre);
  const double trace = about_centre[0][0] + about_centre[1][1] + about_centre[2][2];
  MassProperties result;
  result.volume_m3 = volume;
  result.mass_kg = density_kg_per_m3 * volume;
  result.p_OCom_m = reference + centre;
  result.inertia_Com_kg_m2 = density_kg_per_m3 * (trace * glm::dmat3(1.0) - about_centre);
  return result;
}

}  // namespace vps
