#pragma once

#include <vector>

#include "vps/mesh/triangle_mesh.hpp"

namespace failures {

// A convex outline in the plane (x, z), counter-clockwise seen from -y, drawn out along y about the origin.
vps::TriangleMesh MakePrism(const std::vector<glm::dvec2>& outline, double length_m);

// A box whose four edges along y are rounded.
vps::TriangleMesh MakeRoundedBox(const glm::dvec3& size_m, double radius_m);

}  // namespace failures
