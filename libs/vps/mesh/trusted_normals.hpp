#pragma once

#include <cstdint>
#include <vector>

#include "core/parallel_for.hpp"
#include "vps/mesh/winding_number.hpp"

namespace vps {

// Of each triangle: 1 where, for every point x whose nearest surface point p lies on it, the sign of n . (x - p) is
// right for inside and outside. The segment from x to p meets no triangle, so that the winding number is constant along
// it and equals that of the triangle's own side. That is 0 outside and 1 inside for triangles that lie on the border of
// the solid, cross no other, and whose neighbours at edges and corners do the same and close the surface around them.
std::vector<std::uint8_t> FindTrustedNormals(const TriangleMesh& mesh, const WindingNumber& winding,
                                             core::ParallelFor* workers = nullptr);

}  // namespace vps
