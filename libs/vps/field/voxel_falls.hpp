#pragma once

#include <cstdint>
#include <vector>

#include "core/parallel_for.hpp"
#include "vps/field/distance_field.hpp"

namespace vps {

// How far the field falls below the planes of single voxels just beside them, by coarse cells: what CoarseCell keeps
// for kCloseRadius, in voxels, or infinity where nothing is known. From the field itself, and exact: every voxel is a
// plane or planes combined, so the largest differences are at its corners.
std::vector<float> FindVoxelFalls(const DistanceField& field, core::ParallelFor* workers);

// Most that the plane d + gradient . (p - centre) lies above the crease anywhere in the box |p - centre| <= half, whose
// centre lies at `offset` from the middle of the crease's voxel.
float MostAboveCrease(const DistanceField& field, std::uint32_t record, float d, const glm::vec3& gradient,
                      const glm::vec3& offset, const glm::vec3& half);

}  // namespace vps
