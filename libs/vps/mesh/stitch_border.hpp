#pragma once

#include <cstdint>
#include <vector>

#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

// Mends a surface whose pieces meet in space but not in its lists. `origin[i]`, the number that triangle i has for
// people, goes along. Both return how many corners took part.

// Puts corners of the border (of edges with one triangle) together that are no farther apart than `reach_m`.
std::size_t WeldBorder(double reach_m, TriangleMesh* mesh, std::vector<std::uint32_t>* origin);

// Splits triangles at border corners that lie on their border edges: where one piece has a long edge and its neighbour
// several short ones.
std::size_t SplitAtBorderCorners(double reach_m, TriangleMesh* mesh, std::vector<std::uint32_t>* origin);

}  // namespace vps
