#pragma once

#include <functional>
#include <string_view>

#include "core/result.hpp"
#include "vps/mesh/triangle_mesh.hpp"
#include "vps/voxmap/voxmap.hpp"

namespace vps {

// A grid of more voxels is refused: 1 GB of layers, 3 GB while it is built.
constexpr std::size_t kMaxVoxels = 1'000'000'000;

// Builds the layers: conservative surface voxelisation (a voxel that a triangle touches is surface), outside by flood
// fill from the border, everything else inside, layers by an exact Euclidean distance transform of the surface voxels.
// A void that cannot be reached from outside counts as inside. An open mesh has no inside: only surface voxels (0).
// The lower corner of the mesh's box is put on a voxel centre, where a plane's V is exact. `voxel_size_m` > 0;
// `progress` gets a stage's name and the share of it that is done. Errors: no triangle, voxel size not positive
// (kInvalidInput), more than kMaxVoxels (kResource).
core::Result<Voxmap> BuildVoxmap(const TriangleMesh& mesh, double voxel_size_m,
                                 const std::function<void(std::string_view, double)>& progress = {});

}  // namespace vps
