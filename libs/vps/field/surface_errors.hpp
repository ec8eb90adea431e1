#pragma once

#include <cstdint>
#include <vector>

#include "vps/field/closest_triangle.hpp"
#include "vps/field/distance_field.hpp"

namespace vps {

// DistanceField::errors of a field that is finished but for them: what the field tells at places of the surface itself,
// where it should tell 0; around every brick the root of the mean square or, if that is more, six times the mean, since
// of many places' errors a contact keeps what is of one sign. Weighted by area and by a tent two bricks wide, in steps of
// kErrorStep. Triangles in voxels. A sheet's are 0: they are not measured.
std::vector<std::uint8_t> SurfaceErrors(const TriangleField& triangles, const DistanceField& field);

// Between the bricks around p, in voxels of the field. Voxels.
float SurfaceErrorAt(const DistanceField& field, const glm::vec3& p);

}  // namespace vps
