#pragma once

#include <cmath>

#include "vps/testing/shapes.hpp"

namespace vps {

// A ring of facets as large as 1.2 mm whose corners stand out of the torus by up to `height_m` or lie as deep in it, as
// a scan's do. For tests.
inline TriangleMesh MakeRoughTorus(double height_m) {
  constexpr double kMajor = 0.03;
  TriangleMesh mesh = MakeTorus(kMajor, 0.012, 160, 64);
  std::uint32_t seed = 1;
  for (glm::dvec3& v : mesh.vertices) {
    const glm::dvec3 ring = kMajor * glm::normalize(glm::dvec3(v.x, v.y, 0.0));
    seed = seed * 1664525U + 1013904223U;
    v += height_m * (2.0 * (seed >> 8) / 16777216.0 - 1.0) * glm::normalize(v - ring);
  }
  return mesh;
}

}  // namespace vps
