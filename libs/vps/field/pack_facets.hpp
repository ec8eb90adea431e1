#pragma once

#include <cstddef>

#include "vps/field/closest_triangle.hpp"
#include "vps/field/facets.hpp"

namespace vps {

// What facets may take, in the field's other bytes: those of a sixth of a voxel and less take more, and are too many to
// look at near a point (kMostFacetBlocks).
constexpr double kMostFacetsShare = 4.0;

// Of a solid, triangles in voxels; nothing of a sheet.
// Triangles that are longer than a block reaches are halved until they are not. Nothing if that takes more than
// `most_bytes`.
Facets PackFacets(const TriangleField& triangles, std::size_t most_bytes);

}  // namespace vps
