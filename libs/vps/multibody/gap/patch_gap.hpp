#pragma once

#include "vps/field/nearest_facet.hpp"
#include "vps/multibody/gap/gap.hpp"

namespace vps {

// Of what is nearest to a point: a face's own normal, or from an edge or a corner the way to the point, `above`.
inline glm::dvec3 NormalTo(const NearestFacet& facet, const glm::dvec3& above) {
  const bool is_way = !facet.is_on_face && std::abs(facet.height) > 0.25 * kClear;
  return is_way ? above / facet.height : facet.normal;
}

inline Gap GapAlong(const glm::dvec3& n, const NearestFacet& facet, const glm::dvec3& p) {
  return {true, p, n, glm::dot(p - facet.place, n)};
}

// A flat patch of S over G. It slides over G's faces to the edge or the corner that is right below, as far as the patch
// reaches and S goes on: that touches first, and the normal is S's own. Up a wall it slides only where S goes on inside
// the wall: a needle that stands in a plate is felt, the wall along a peg that ends there is not under it.
Gap OverPatch(const GapScene& scene, const FacetsAround& around, const PlaceInG& place);

}  // namespace vps
