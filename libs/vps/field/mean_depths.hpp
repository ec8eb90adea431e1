#pragma once

#include "vps/field/distance_field.hpp"

namespace vps {

// Replaces the distance at the centre of coarse cells inside the solid by its mean over the cell (decision 13),
//
//   mean d = d + sum over axes of (second difference of the centres' distances) / 24   [voxels],
//
// derived in the .cpp. Within a convex part depth is the least of several distances and so less than its tangent
// plane: points of a deep contact would get too much depth. Conservative bounds of the distance are not affected: at
// centres inside none is above zero.
void ComputeMeanDepths(DistanceField* field);

}  // namespace vps
