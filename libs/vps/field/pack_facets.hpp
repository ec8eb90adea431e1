#pragma once

#include <cstddef>

#include "vps/field/closest_triangle.hpp"
#include "vps/field/facets.hpp"

namespace vps {

// Largest memory of facets as a multiple of the rest of the field (decision 12, "at coarse voxels, too"; twice that
// since corners take twice the memory). Facets of less than a sixth of a voxel take more, and are too many near one
// point (kMostFacetBlocks).
constexpr double kMostFacetsShare = 8.0;

// Packs the triangles of a solid, in voxels. Triangles longer than a block reaches are halved until they fit. Empty if
// it takes more than `most_bytes`.
Facets PackFacets(const TriangleField& triangles, std::size_t most_bytes);

// For facets whose blocks and spheres were read from a file, too.
void MakeBoxes(Facets* facets);

}  // namespace vps
