#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace contact_peers {

// One build of one field of one mesh.
struct BuildMeasurement {
  std::string mesh, method;  // "fast" or "OpenVDB"
  int voxels = 0;            // along the mesh's longest side
  int threads = 0;
  double time_s = 0.0;        // median of the repetitions
  double stored_bytes = 0.0;  // of the result
  double peak_bytes = 0.0;    // more than before the build, result included
};

// Builds the distance field of `fast` and OpenVDB's level set (meshToLevelSet) of the same meshes with the same voxels,
// the same band (3 voxels to each side) and the same number of threads, turn about. Meshes: the bunny, the nut
// and the bolt of the folder, those that are there, and a block with a hole.
core::Result<std::vector<BuildMeasurement>> CompareBuilds(const std::filesystem::path& meshes);

}  // namespace contact_peers
