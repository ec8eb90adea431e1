#pragma once

#include "vps/field/closest_triangle.hpp"
#include "vps/field/distance_field.hpp"

namespace vps {

// What the surface around each brick of a field is like, in the mean weighted by area and by a tent two bricks wide.
// Triangles in voxels. A sheet has none of both: its two sides cancel everywhere, and its errors are not measured.
//
// field->bends: the sum of the principal curvatures, in steps of kBendStep; 0 where there is no surface. Of a mesh it
// is exact in the mean: all curvature is at the edges, and the surface's integral of it is that of the turn of the
// normal along them, the sum of angle times length (Cohen-Steiner and Morvan 2003). Sharp edges, of more than 25
// degrees, do not count. Where two sides of a thin wall are in one brick they cancel.
//
// field->errors: what the field, whose bricks are ready, tells at places of the surface itself, where it should tell 0:
// the root of the mean square or, if that is more, six times the mean, since of many places' errors a contact keeps
// what is of one sign; in steps of kErrorStep.
void TakeBrickTraits(const TriangleField& triangles, DistanceField* field);

// The field's error between the bricks around p, both in voxels.
float SurfaceErrorAt(const DistanceField& field, const glm::vec3& p);

}  // namespace vps
