#pragma once

#include <cstdint>
#include <vector>

#include "vps/mesh/winding_number.hpp"

namespace vps {

// Of each triangle: 1 where its normal tells inside from outside for every point whose nearest surface point it holds.
// The way from such a point to the surface meets no triangle, so that the winding number does not change along it: it
// is the one of the triangle's own side. That is 0 outside and 1 inside for triangles that lie on the border of the
// solid, pass through no other, and whose neighbours at edges and corners do the same and close the surface around
// them.
std::vector<std::uint8_t> FindTrustedNormals(const TriangleMesh& mesh, const WindingNumber& winding);

}  // namespace vps
