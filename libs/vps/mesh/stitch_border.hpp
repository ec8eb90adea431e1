#pragma once

#include <cstdint>
#include <vector>

#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// Repairs of a surface whose pieces coincide in space without sharing vertices. `origin[i]`, the number of triangle i
// in its file, is kept up to date. Both return the number of corners merged or inserted.

// Merges corners of the border (of edges with one triangle) that are at most `reach_m` apart.
std::size_t WeldBorder(double reach_m, TriangleMesh* mesh, std::vector<std::uint32_t>* origin);

// Splits triangles at border corners that lie on their border edges: where one piece has a long edge and its neighbour
// several short ones.
std::size_t SplitAtBorderCorners(double reach_m, TriangleMesh* mesh, std::vector<std::uint32_t>* origin);

}  // namespace vps
