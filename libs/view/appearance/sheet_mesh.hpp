#pragma once

#include "view/scene.hpp"
#include "vps/mesh/load_mesh.hpp"

namespace view {

// A sheet as triangles in W, kSheetRefinement per cell along each side: a smooth surface through the nodes, with
// normals perturbed like those of crumpled foil. The perturbation is fixed in the material. The number of vertices and
// the triangles depend only on the number of nodes.
constexpr int kSheetRefinement = 3;  // by eye; vertices grow with its square
vps::VisualPrimitive MakeSheetMesh(const Sheet& sheet);

}  // namespace view
