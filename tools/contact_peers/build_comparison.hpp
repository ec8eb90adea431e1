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
// the same band (3 voxels to each side) and the same number of threads, turn about, each in a process of its own.
// Meshes: a block with a hole, and of the folder the bunny and the nut, those that are there.
core::Result<std::vector<BuildMeasurement>> CompareBuilds(const std::filesystem::path& meshes);

// What such a process does. Arguments: the program, kBuildVerb, method, folder of meshes, mesh, voxels, threads. Prints
// time (s), bytes stored and peak bytes; returns the program's exit status.
constexpr const char* kBuildVerb = "build-once";
int BuildOnce(int argc, char** argv);

}  // namespace contact_peers
