#pragma once

#include "core/parallel_for.hpp"
#include "vps/field/distance_field.hpp"

namespace vps {

// Writes the bounds of the coarse cells (CoarseCell) near the surface, from the field itself. With them a walk can cull
// points that face a surface closely without touching it. Exact but for rounding up: every cell is a plane or planes
// combined, so the largest differences are at its corners. `workers` may be null; the result is the same.
void BoundCells(DistanceField* field, core::ParallelFor* workers);

}  // namespace vps
