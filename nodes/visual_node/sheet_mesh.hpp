#pragma once

#include "view/scene.hpp"
#include "vps/mesh/load_mesh.hpp"

namespace visual_node {

// A sheet as triangles in W, kSheetRefinement to a cell along each side: a smooth surface through the nodes, whose
// normals are dented as those of crumpled foil. The dents belong to the material, so they move with it. The number of
// vertices and the triangles depend on the number of nodes only.
constexpr int kSheetRefinement = 3;
vps::VisualPrimitive MakeSheetMesh(const view::Sheet& sheet);

}  // namespace visual_node
