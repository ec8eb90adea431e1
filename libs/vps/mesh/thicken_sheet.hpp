#pragma once

#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// The solid that a sheet stands for: its surface moved by half the thickness to both sides, closed along its border.
// Faces keep their distance of half a thickness at folds up to 120 degrees (corners move along the mean normal by as
// much more as the fold asks for, at most twice). Patches that only touch, or that no orientation makes agree, become
// solids of their own that overlap.
TriangleMesh ThickenSheet(const TriangleMesh& sheet, double thickness_m);

}  // namespace vps
