#pragma once

#include <cstdint>
#include <vector>

#include "vps/field/closest_triangle.hpp"
#include "vps/field/distance_field.hpp"

namespace vps {

// DistanceField::bends of a field with this layout: of every brick the sum of the principal curvatures of the surface
// around it (a mean, weighted by area and by a tent two bricks wide; 0 where there is none), in steps of kBendStep.
//
// Of a mesh it is exact in the mean: all curvature is at the edges, and the surface's integral of it is that of the
// turn of the normal along them, the sum of angle times length (Cohen-Steiner and Morvan 2003). Sharp edges, of more
// than 25 degrees, do not count. Where two sides of a thin wall are in one brick they cancel. Triangles in voxels. A
// sheet has none: its two sides cancel everywhere.
std::vector<std::int16_t> SurfaceBends(const TriangleField& triangles, const DistanceField& layout);

}  // namespace vps
