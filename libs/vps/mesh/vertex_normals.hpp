#pragma once

#include "vps/mesh/load_mesh.hpp"

namespace vps {

// Corner normals: the area-weighted mean of the normals of those faces around the corner's vertex that meet the
// corner's own face at less than `crease_rad`. Corners of a vertex with equal normals share one drawn vertex.
VisualPrimitive SplitAtCreases(const TriangleMesh& mesh, double crease_rad);

}  // namespace vps
