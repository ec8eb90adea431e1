#pragma once

#include <cstdint>

#include "vps/field/distance_field.hpp"

namespace vps {

// The close bounds of CoarseCell, one for each coarse cell of layer `z`, x fastest: how far the field lies below the
// plane of a voxel within kCloseRadius of it, in voxels, or infinity where nothing is known. From the field itself, and
// exact: every voxel is a plane or planes combined, so the largest differences are at its corners.
void FindVoxelFalls(const DistanceField& field, int z, float* falls);

// Largest value of the plane d + gradient . (p - centre) minus the crease over the box |p - centre| <= half, whose
// centre lies at `offset` from the middle of the crease's voxel.
float MostAboveCrease(const DistanceField& field, std::uint32_t record, float d, const glm::vec3& gradient,
                      const glm::vec3& offset, const glm::vec3& half);

}  // namespace vps
