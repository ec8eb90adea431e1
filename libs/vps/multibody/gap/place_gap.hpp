#pragma once

#include "vps/multibody/gap/corner_gap.hpp"

namespace vps {

// The gaps of a place of S that is so deep by the field, exact where they can be small; not found on the side that
// faces away. Adds the corners of G that are below it.
Gaps MeasurePlace(const GapScene& scene, std::uint32_t point, double depth, FacetsAround* around, CornersBelow* below);

}  // namespace vps
