#pragma once

#include <functional>
#include <string_view>

#include "core/result.hpp"
#include "vps/field/distance_field.hpp"
#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// More voxels than this in the box are refused; memory grows with the surface and with 1/512 of the box per coarse
// cell's edge, not with the box's voxels.
constexpr double kMaxFieldVoxels = 3e10;

// Builds the field of a closed mesh: nearest triangles in the band by raster, signs by pseudonormals, creases fitted,
// the coarse grid by a bounding volume hierarchy. Errors: no triangle, voxel size not positive or far too small.
core::Result<DistanceField> BuildField(const TriangleMesh& mesh, double voxel_size_m,
                                       const std::function<void(std::string_view, double)>& progress = {});

}  // namespace vps
