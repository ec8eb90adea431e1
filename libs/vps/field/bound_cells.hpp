#pragma once

#include <functional>
#include <vector>

#include "core/parallel_for.hpp"
#include "vps/field/distance_field.hpp"

namespace vps {

// The coarse cells with their bounds (CoarseCell) near the surface, from the field itself. With them a walk can cull
// points that face a surface closely without touching it. Exact but for rounding up: every cell is a plane or planes
// combined, so the largest differences are at its corners. `workers` may be null; the result is the same.
//
// `beside` is called once, by one worker while the others bound cells. It must not change what they read: words,
// bricks, creases, coarse cells and the numbers of voxels.
std::vector<CoarseCell> BoundCells(const DistanceField& field, core::ParallelFor* workers,
                                   const std::function<void()>& beside);

}  // namespace vps
