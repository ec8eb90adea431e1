#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/parallel_for.hpp"
#include "core/result.hpp"
#include "vps/asset/method.hpp"
#include "vps/field/distance_field.hpp"
#include "vps/mesh/triangle_mesh.hpp"
#include "vps/sampling/sample_tree.hpp"
#include "vps/surface/field_bends.hpp"
#include "vps/surface/surface_tree.hpp"
#include "vps/tree/point_tree.hpp"
#include "vps/voxmap/voxmap.hpp"

namespace vps {

// The collision data of one object, built once and shared read-only. Mesh frame, metres.
struct CookedObject {
  std::optional<Voxmap> voxmap;        // field side, method paper
  std::optional<PointTree> points;     // sampled side, method paper
  std::optional<DistanceField> field;  // field side, method fast
  std::optional<FieldBends> bends;     // of the field
  std::optional<SampleTree> samples;   // sampled side, method fast
  std::vector<SampleTree> coarser;     // of the same surface: each has a quarter of the points of the one before
  std::optional<SurfaceTree> surface;  // likewise
  glm::dvec3 bounding_centre_m{0.0};
  double bounding_radius_m = 0.0;
  bool is_from_cache = false;  // all that is there
  std::string cache_note;      // a damaged cache file that was built anew, or one that could not be written

  [[nodiscard]] bool has_field(Method method) const {
    return method == Method::kFast ? field.has_value() : voxmap.has_value();
  }
  [[nodiscard]] bool has_points(Method method) const {
    return method == Method::kFast ? samples.has_value() : points.has_value();
  }
  // The samples, or coarser ones; the coarsest if there are none so coarse.
  [[nodiscard]] const SampleTree& SamplesAt(std::uint32_t coarseness) const {
    const std::size_t c = std::min<std::size_t>(coarseness, coarser.size());
    return c == 0 ? *samples : coarser[c - 1];
  }
  // Of the field side; 0 when there is none.
  [[nodiscard]] double voxel_size_m() const {
    return field ? field->voxel_size_m : (voxmap ? voxmap->voxel_size_m : 0.0);
  }
};

// Stage name and fraction done in [0, 1]; called a few hundred times at most, by one thread at a time, which may be a
// worker.
using Progress = std::function<void(std::string_view stage, double fraction)>;

struct CookParameters {
  double voxel_size_m = 0.0;     // 0: no field side
  std::uint32_t num_points = 0;  // 0: no sampled side
  Method method = Method::kPaper;
  // 0: the mesh bounds a solid. Else it is a sheet with two sides, and the solid is ThickenSheet's.
  double sheet_half_thickness_m = 0.0;
};

// Builds from a mesh in memory, which must be as CheckMesh leaves it. Errors: those of the builders, an inside-out
// mesh, and a sheet thinner than voxels of this size resolve (LimitsOf). `workers` share the work; the result is the
// same without.
core::Result<CookedObject> Cook(const TriangleMesh& mesh, const CookParameters& parameters,
                                const Progress& progress = {}, core::ParallelFor* workers = nullptr);

// Loads the mesh file, checks and mends it (CheckMesh, CheckPartSize), and takes the structures from the cache, or
// builds and stores them. Field and sampled side have a cache file each, which is addressed by content (bytes of the
// mesh, parameters of the side, format version), so that a side is built once whoever needs the other; a damaged one is
// rebuilt, never trusted. A cache folder that cannot be written is no error. Empty `cache_folder`:
// DefaultCacheFolder().
core::Result<CookedObject> Cook(const std::filesystem::path& mesh_file, const CookParameters& parameters,
                                const std::filesystem::path& cache_folder = {}, const Progress& progress = {},
                                core::ParallelFor* workers = nullptr);

// $VR_OOS_CACHE, else $XDG_CACHE_HOME/vr_oos, else ~/.cache/vr_oos.
std::filesystem::path DefaultCacheFolder();

}  // namespace vps
