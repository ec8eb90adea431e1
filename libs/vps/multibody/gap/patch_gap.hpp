#pragma once

#include "vps/field/nearest_facet.hpp"
#include "vps/multibody/gap/gap.hpp"

namespace vps {

// A flat patch of S over G. It slides over G's faces to the edge or the corner that is right below, as far as the patch
// reaches and S goes on: that touches first, and the normal is S's own. Up a wall it slides only where S goes on inside
// the wall: a needle that stands in a plate is felt, the wall along a peg that ends there is not under it.
Gap OverPatch(const GapScene& scene, const FacetsAround& around, const PlaceInG& place);

}  // namespace vps
