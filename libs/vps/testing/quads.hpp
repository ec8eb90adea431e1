#pragma once

#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// Two triangles of a quad a b c d, counter-clockwise seen from outside, cut from a to c.
inline void AddQuad(TriangleMesh* mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  mesh->triangles.push_back({a, b, c});
  mesh->triangles.push_back({a, c, d});
}

}  // namespace vps
