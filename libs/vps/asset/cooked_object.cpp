#include "vps/asset/cooked_object.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "vps/asset/cooked_file.hpp"
#include "vps/mesh/load_mesh.hpp"
#include "vps/pointshell/pointshell.hpp"
#include "vps/tree/build_tree.hpp"
#include "vps/voxmap/build_voxmap.hpp"

namespace vps {
namespace {

core::Result<std::vector<char>> ReadAll(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) {
    return core::Fail(core::ErrorCode::kNotFound,
                      file.string() + ": cannot open the mesh. Fix: check the path and that it can be read.");
  }
  return std::vector<char>(std::istreambuf_iterator<char>(in), {});
}

std::filesystem::path CacheFile(const std::filesystem::path& folder, const std::filesystem::path& mesh_file,
                                std::uint64_t key) {
  char digits[17];
  std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(key));
  return folder / (mesh_file.stem().string() + "-" + digits + ".vps");
}

}  // namespace

core::Result<CookedObject> Cook(const TriangleMesh& mesh, const CookParameters& parameters, const Progress& progress) {
  CookedObject object;
  const Box box = BoundingBox(mesh);
  object.bounding_centre_m = 0.5 * (box.lower + box.upper);
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t vertex : triangle) {
      object.bounding_radius_m =
          std::max(object.bounding_radius_m, glm::distance(mesh.vertices[vertex], object.bounding_centre_m));
    }
  }
  if (parameters.voxel_size_m > 0.0) {
    auto map = BuildVoxmap(mesh, parameters.voxel_size_m, progress);
    if (!map) return tl::unexpected(map.error());
    object.voxmap = std::move(*map);
  }
  if (parameters.num_points > 0) {
    auto shell = BuildPointshell(mesh, parameters.num_points, progress);
    if (!shell) return tl::unexpected(shell.error());
    if (progress) progress("sphere tree", 0.0);
    object.points = BuildTree(*shell);
    if (progress) progress("sphere tree", 1.0);
  }
  return object;
}

core::Result<CookedObject> Cook(const std::filesystem::path& mesh_file, const CookParameters& parameters,
                                const std::filesystem::path& cache_folder, const Progress& progress) {
  const auto bytes = ReadAll(mesh_file);
  if (!bytes) return tl::unexpected(bytes.error());
  const std::uint64_t key = CookedKey(bytes->data(), bytes->size(), parameters);
  const std::filesystem::path file =
      CacheFile(cache_folder.empty() ? DefaultCacheFolder() : cache_folder, mesh_file, key);
  if (auto cached = ReadCookedFile(file, key)) return cached;

  const auto mesh = LoadMesh(mesh_file);
  if (!mesh) return tl::unexpected(mesh.error());
  auto object = Cook(*mesh, parameters, progress);
  if (!object) {
    return core::Fail(object.error().code, mesh_file.string() + ": " + object.error().detail);
  }
  // A cache that cannot be written only costs the next start some seconds.
  static_cast<void>(WriteCookedFile(file, key, *object));
  return object;
}

std::filesystem::path DefaultCacheFolder() {
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return std::filesystem::path(value != nullptr ? value : "");
  };
  if (!variable("VR_OOS_CACHE").empty()) return variable("VR_OOS_CACHE");
  if (!variable("XDG_CACHE_HOME").empty()) return variable("XDG_CACHE_HOME") / "vr_oos";
  if (!variable("HOME").empty()) return variable("HOME") / ".cache" / "vr_oos";
  return std::filesystem::temp_directory_path() / "vr_oos_cache";
}

}  // namespace vps
