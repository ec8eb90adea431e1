#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>

#include "core/result.hpp"
#include "vps/mesh/triangle_mesh.hpp"
#include "vps/tree/point_tree.hpp"
#include "vps/voxmap/voxmap.hpp"

namespace vps {

// Everything that collision needs to know of one object, built once and shared read-only. Mesh frame, metres.
struct CookedObject {
  std::optional<Voxmap> voxmap;     // field side
  std::optional<PointTree> points;  // sampled side
  glm::dvec3 bounding_centre_m{0.0};
  double bounding_radius_m = 0.0;
  bool is_from_cache = false;
};

// Stage name and fraction done in [0, 1]; called from the building thread, a few hundred times at most.
using Progress = std::function<void(std::string_view stage, double fraction)>;

struct CookParameters {
  double voxel_size_m = 0.0;     // 0: no voxelmap
  std::uint32_t num_points = 0;  // 0: no pointshell
};

// Builds from a mesh in memory.
core::Result<CookedObject> Cook(const TriangleMesh& mesh, const CookParameters& parameters,
                                const Progress& progress = {});

// Loads the mesh file and takes the structures from the cache, or builds and stores them. The cache file is addressed
// by content (bytes of the mesh, parameters, format version); a damaged one is rebuilt, never trusted. A cache folder
// that cannot be written is no error. Empty `cache_folder`: DefaultCacheFolder().
core::Result<CookedObject> Cook(const std::filesystem::path& mesh_file, const CookParameters& parameters,
                                const std::filesystem::path& cache_folder = {}, const Progress& progress = {});

// $VR_OOS_CACHE, else $XDG_CACHE_HOME/vr_oos, else ~/.cache/vr_oos.
std::filesystem::path DefaultCacheFolder();

}  // namespace vps
