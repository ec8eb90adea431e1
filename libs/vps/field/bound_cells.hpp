#pragma once

#include <vector>

#include "vps/field/distance_field.hpp"

namespace vps {

// The coarse cells with their bounds (CoarseCell) near the surface, from the field itself. With them a walk can cull
// points that face a surface closely without touching it. Exact but for rounding up: every cell is a plane or planes
// combined, so the largest differences are at its corners.
std::vector<CoarseCell> BoundCells(const DistanceField& field);

}  // namespace vps
