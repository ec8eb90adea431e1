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

struct BuildFieldOptions {
  // 0: the mesh bounds a solid. Else the mesh is a sheet, open or not, with two sides and no inside: the solid is
  // everything nearer to a triangle than this, and the field is the unsigned distance less it.
  double sheet_half_thickness_m = 0.0;
  // Signs by winding number, for a mesh that is no simple solid (IsSimpleSolid); slower than pseudonormals.
  bool sign_by_winding = false;
  std::function<void(std::string_view stage, double fraction)> progress;
};

// Builds the field of a mesh: nearest triangles in the band by raster, signs by pseudonormals, creases fitted, the
// coarse grid by a bounding volume hierarchy. Errors: no triangle, voxel size not positive or far too small, thickness
// negative.
core::Result<DistanceField> BuildField(const TriangleMesh& mesh, double voxel_size_m,
                                       const BuildFieldOptions& options = {});

}  // namespace vps
