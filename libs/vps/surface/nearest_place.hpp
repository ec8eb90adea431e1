#pragma once

#include "vps/surface/surface_tree.hpp"

namespace vps {

// The place of a surface that is nearest to a point. Mesh frame, metres.
struct NearestPlace {
  bool is_found = false;
  glm::dvec3 place{0.0};
  glm::dvec3 outward{0.0};  // unit
};

// Of the triangles whose outer side p is on; of those that meet at the nearest place, the one above whose plane q is
// highest. Not found: nothing within `reach_m`. Does not allocate.
NearestPlace FindNearestPlace(const SurfaceTree& surface, const glm::dvec3& p, const glm::dvec3& q,
                              double reach_m) noexcept;

}  // namespace vps
