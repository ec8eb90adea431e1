#pragma once

#include <array>
#include <glm/glm.hpp>

#include "vps/field/distance_field.hpp"

namespace vps {

// The place of a field's own triangles that is nearest to a point. In voxels of the field.
struct NearestFacet {
  bool is_found = false;
  bool is_on_face = false;  // else on an edge or a corner
  glm::dvec3 place{0.0};
  glm::dvec3 normal{0.0};  // unit, outwards, of the triangle whose side the point is on
  double height = 0.0;     // distance, negative inside
  std::array<glm::dvec3, 3> corners{};
};

// Not found: nothing within `reach`, or the side of the nearest triangle is in doubt. Does not allocate.
NearestFacet FindNearestFacet(const Facets& facets, const glm::dvec3& p, double reach) noexcept;

}  // namespace vps
