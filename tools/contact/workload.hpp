#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/pose.hpp"
#include "vps/mesh/triangle_mesh.hpp"

namespace contact {

// A pair of meshes and poses at which they touch.
struct Workload {
  std::string name;         // a file's name can be made of it
  std::string description;  // one sentence
  vps::TriangleMesh A, B;
  std::vector<core::Pose> poses;  // X_AB
  double voxel_size_m = 1e-3;     // the middle of the sweep
  double oracle_accuracy = 1e-3;
};

struct Workloads {
  std::vector<Workload> found;
  std::vector<std::string> skipped;  // "nut_bolt: no file ..."
};

// Analytic pairs, a peg pressed in its hole, parts of `scenarios_folder`, and pairs of the public meshes in
// `meshes_folder`; those whose files are missing are named in `skipped`. Always the same poses.
Workloads MakeWorkloads(const std::filesystem::path& scenarios_folder, const std::filesystem::path& meshes_folder);

}  // namespace contact
