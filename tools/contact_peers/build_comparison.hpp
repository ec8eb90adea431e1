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
  double stored_bytes = 0.0;  // size of the result
  double peak_bytes = 0.0;    // peak resident memory less that before the build; the result included
};

// Builds the distance field of `fast` and OpenVDB's level set (meshToLevelSet) of the same meshes with the same voxels,
// the same narrow band (3 voxels to each side) and the same number of threads, turn about, each in a process of its
// own. Meshes: a block with a hole, and the bunny and the nut where the folder has them. Errors: a process that fails.
core::Result<std::vector<BuildMeasurement>> CompareBuilds(const std::filesystem::path& meshes);

// The main function of such a process. Arguments: the program, kBuildVerb, method, folder of meshes, mesh, voxels,
// threads. Prints time [s], stored bytes and peak bytes; returns the exit status.
constexpr const char* kBuildVerb = "build-once";
int BuildOnce(int argc, char** argv);

}  // namespace contact_peers
