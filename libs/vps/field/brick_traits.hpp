#pragma once

#include "vps/field/closest_triangle.hpp"
#include "vps/field/distance_field.hpp"

namespace vps {

// Curvature and reconstruction error of the surface around each brick of a field, as means weighted by area and by a
// trilinear tent two bricks wide. Triangles in voxels; `field` with its bricks and coarse grid ready.
//
// field->curvatures: the sum of the principal curvatures k1 + k2 [1/voxel], in steps of kCurvatureStep; 0 where there
// is no surface. The curvature of a mesh is all at its edges; its integral over a region B of the surface is
//
//   integral of (k1 + k2) dA = sum over edges of angle(e) length(e in B)   (Cohen-Steiner and Morvan 2003),
//
// angle > 0 where the surface bulges. Sharp edges, of more than 25 degrees, do not count. Where two sides of a thin
// wall are in one brick they cancel.
//
// field->errors: the field at places of the surface itself, where it should be 0: the larger of the root mean square
// and six times the mean, since errors of one sign do not average out in a contact; in steps of kErrorStep.
void ComputeBrickTraits(const TriangleField& triangles, DistanceField* field);

// The reconstruction error at p [voxels], interpolated between the bricks around it; p in voxels.
float SurfaceErrorAt(const DistanceField& field, const glm::vec3& p);

}  // namespace vps
