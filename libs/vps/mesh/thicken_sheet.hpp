#pragma once

#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// The solid that a sheet represents: its surface moved by half the thickness to both sides, closed along its border. A
// corner moves by thickness / (2 m . n) along the angle-weighted mean normal m of its faces, n of the face that leans
// most, but at most by the whole thickness: so faces stay half a thickness away at folds up to 120 degrees. Patches
// that only touch, or that cannot be oriented consistently, become overlapping solids of their own.
TriangleMesh ThickenSheet(const TriangleMesh& sheet, double thickness_m);

}  // namespace vps
