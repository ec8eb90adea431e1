#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "core/hash.hpp"
#include "vps/asset/cooked_file.hpp"
#include "vps/asset/cooked_object.hpp"
#include "vps/field/build_field.hpp"
#include "vps/mesh/load_mesh.hpp"
#include "vps/tree/build_tree.hpp"
#include "vps/voxmap/build_voxmap.hpp"

namespace vps {
namespace {

// Inward normals and look-ahead planes point the wrong way on a mesh whose faces look inwards.
bool IsInsideOut(const TriangleMesh& mesh) {
  if (CountOpenEdges(mesh) != 0) return false;
  const Box box = BoundingBox(mesh);
  double volume = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = mesh.corners(i);
    volume += glm::dot(a - box.lower, glm::cross(b - box.lower, c - box.lower)) / 6.0;
  }
  return volume < 0.0;
}

std::uint64_t HashOf(const TriangleMesh& mesh) {
  const std::uint64_t vertices = core::Hash64(mesh.vertices.data(), mesh.vertices.size() * sizeof(mesh.vertices[0]));
  return core::Hash64(mesh.triangles.data(), mesh.triangles.size() * sizeof(mesh.triangles[0]), vertices);
}

}  // namespace

core::Result<CookedObject> Cook(const TriangleMesh& mesh, const CookParameters& parameters, const Progress& progress) {
  if (mesh.triangles.empty()) return core::Fail(core::ErrorCode::kInvalidInput, "the mesh has no triangles");
  if (parameters.sheet_half_thickness_m == 0.0 && IsInsideOut(mesh)) {
    return core::Fail(core::ErrorCode::kInvalidInput, "the mesh is inside out: turn its faces over");
  }
  CookedObject object;
  const Box box = BoundingBox(mesh);
  object.bounding_centre_m = 0.5 * (box.lower + box.upper);
  for (const auto& p : mesh.vertices) {
    object.bounding_radius_m = std::max(object.bounding_radius_m, glm::length(p - object.bounding_centre_m));
  }
  if (parameters.method == Method::kFast) {
    if (parameters.voxel_size_m != 0.0) {
      auto field = BuildField(mesh, parameters.voxel_size_m,
                              {.sheet_half_thickness_m = parameters.sheet_half_thickness_m, .progress = progress});
      if (!field) return tl::unexpected(field.error());
      object.field = std::move(*field);
    }
    if (parameters.num_points != 0) {
      const auto samples = SampleSurface(mesh, parameters.num_points, progress);
      if (!samples) return tl::unexpected(samples.error());
      object.samples = BuildSampleTree(*samples);
    }
    return object;
  }
  if (parameters.voxel_size_m != 0.0) {
    auto voxmap = BuildVoxmap(mesh, parameters.voxel_size_m, progress);
    if (!voxmap) return tl::unexpected(voxmap.error());
    object.voxmap = std::move(*voxmap);
  }
  if (parameters.num_points != 0) {
    const auto shell = BuildPointshell(mesh, parameters.num_points, progress);
    if (!shell) return tl::unexpected(shell.error());
    if (progress) progress("point-sphere tree", 0.0);
    object.points = BuildTree(*shell);
    if (progress) progress("point-sphere tree", 1.0);
  }
  return object;
}

core::Result<CookedObject> Cook(const std::filesystem::path& mesh_file, const CookParameters& parameters,
                                const std::filesystem::path& cache_folder, const Progress& progress) {
  const auto mesh = LoadMesh(mesh_file);
  if (!mesh) return tl::unexpected(mesh.error());
  // The loaded triangles stand for the file's bytes: a .gltf may keep its vertices in another file.
  const std::uint64_t mesh_hash = HashOf(*mesh);
  const std::uint64_t key = CookedKey(&mesh_hash, sizeof(mesh_hash), parameters);
  char digits[17];
  std::snprintf(digits, sizeof(digits), "%016llx", static_cast<unsigned long long>(key));
  const std::filesystem::path file = (cache_folder.empty() ? DefaultCacheFolder() : cache_folder) /
                                     (mesh_file.stem().string() + "-" + digits + ".vps");
  if (auto cached = ReadCookedFile(file, key)) return cached;
  auto object = Cook(*mesh, parameters, progress);
  if (!object) return core::Fail(object.error().code, mesh_file.string() + ": " + object.error().detail);
  static_cast<void>(WriteCookedFile(file, key, *object));  // without a cache the next start is slower, nothing else
  return object;
}

std::filesystem::path DefaultCacheFolder() {
  if (const char* folder = std::getenv("VR_OOS_CACHE"); folder != nullptr && *folder != '\0') return folder;
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache != nullptr && *cache != '\0') {
    return std::filesystem::path(cache) / "vr_oos";
  }
  if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0') {
    return std::filesystem::path(home) / ".cache" / "vr_oos";
  }
  return std::filesystem::temp_directory_path() / "vr_oos";
}

}  // namespace vps
