#pragma once

#include "vps/field/distance_field.hpp"

namespace vps {

// Of coarse cells inside the solid, takes the depth in the mean over the cell for that at its centre. Within a convex
// part depth is the least of several distances, so away from the centre it is less than its tangent there: points
// strewn over a deep contact would be told too deep (decision 13).
//
// Lower bounds of the distance are not concerned: at such centres there is none above zero.
void TakeMeanDepths(DistanceField* field);

}  // namespace vps
