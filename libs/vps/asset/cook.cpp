#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/hash.hpp"
#include "vps/asset/cooked_file.hpp"
#include "vps/asset/cooked_object.hpp"
#include "vps/asset/feature_size.hpp"
#include "vps/field/build_field.hpp"
#include "vps/mesh/check_mesh.hpp"
#include "vps/mesh/load_mesh.hpp"
#include "vps/mesh/part_size.hpp"
#include "vps/mesh/thicken_sheet.hpp"
#include "vps/tree/build_tree.hpp"
#include "vps/voxmap/build_voxmap.hpp"

namespace vps {
namespace {

// On a mesh with inward faces the points' normals and the look-ahead planes would point the wrong way.
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

core::Result<void> CheckSheetThickness(const CookParameters& parameters) {
  const double thickness_m = 2.0 * parameters.sheet_half_thickness_m;
  const double least_m = LimitsOf(parameters.method, parameters.voxel_size_m).thickness_m;
  if (!(thickness_m >= 0.0)) return core::Fail(core::ErrorCode::kInvalidInput, "a sheet's thickness is negative");
  if (thickness_m == 0.0 || thickness_m >= least_m * (1.0 - 1e-9)) return {};
  char text[160];
  std::snprintf(text, sizeof text, "a sheet of %.4g mm is too thin for voxels of %.4g mm: take voxels of %.4g mm",
                1e3 * thickness_m, 1e3 * parameters.voxel_size_m,
                1e3 * thickness_m / least_m * parameters.voxel_size_m);
  return core::Fail(core::ErrorCode::kInvalidInput, text);
}

// Not derived: a contact of still coarser samples has a handful of them.
constexpr std::uint32_t kFewestSamples = 256;

// Not derived: leaves of a few samples.
double LongestPatch_m(double area_m2, std::uint32_t num_points) {
  return 4.0 * std::sqrt(area_m2 / num_points);
}

// The sampled side of `fast`. Two workers make the levels, each every second one, so that no more than two are in
// memory. Of the finest level only the blue noise is made there, which one worker has to thin in order; what is left of
// it all workers share.
core::Result<void> AddSamples(const TriangleMesh& solid, std::uint32_t num_points, const Progress& progress,
                              core::ParallelFor* workers, CookedObject* object) {
  const auto plan = PlanSampling(solid, num_points, workers);
  if (!plan) return tl::unexpected(plan.error());
  std::vector<std::uint32_t> coarser;
  for (std::uint32_t n = num_points / 4; n >= kFewestSamples; n /= 4) coarser.push_back(n);
  core::Result<Pointshell> shell;
  std::vector<core::Result<SurfaceSamples>> levels(coarser.size());
  core::ForEach(workers, 2, [&](std::size_t half) {
    if (half == 1) shell = BuildPointshell(solid, num_points, progress);
    for (std::size_t i = half; i < levels.size(); i += 2) levels[i] = SampleSurface(solid, coarser[i]);
  });
  if (!shell) return tl::unexpected(shell.error());
  const SurfaceSamples finest = SpreadSamples(solid, *plan, std::move(*shell), progress, workers);
  if (progress) progress("points: trees", 0.0);
  object->samples.emplace();
  object->surface.emplace();
  for (const auto& level : levels) {
    if (!level) return tl::unexpected(level.error());
    object->coarser.emplace_back();
  }
  // One worker builds one of them; the surface takes longest.
  core::ForEach(workers, levels.size() + 2, [&](std::size_t i) {
    if (i == 0) {
      *object->surface = BuildSurfaceTree(solid, LongestPatch_m(SurfaceArea_m2(solid), num_points));
    } else if (i == 1) {
      *object->samples = BuildSampleTree(finest);
    } else {
      object->coarser[i - 2] = BuildSampleTree(*levels[i - 2]);
    }
  });
  if (progress) progress("points: trees", 1.0);
  return {};
}

core::Result<CookedObject> Build(const TriangleMesh& solid, const CookParameters& parameters, const Progress& progress,
                                 core::ParallelFor* workers) {
  CookedObject object;
  const Box box = BoundingBox(solid);
  object.bounding_centre_m = 0.5 * (box.lower + box.upper);
  for (const auto& p : solid.vertices) {
    object.bounding_radius_m = std::max(object.bounding_radius_m, glm::length(p - object.bounding_centre_m));
  }
  if (parameters.method == Method::kFast) {
    if (parameters.voxel_size_m != 0.0) {
      auto field = BuildField(solid, parameters.voxel_size_m,
                              {.signs = IsSimpleSolid(solid, workers) ? Signs::kNormals : Signs::kWinding,
                               .workers = workers,
                               .progress = progress});
      if (!field) return tl::unexpected(field.error());
      object.field = std::move(*field);
      if (progress) progress("bends of the field", 0.0);
      object.bends = BuildFieldBends(*object.field, workers);
      if (progress) progress("bends of the field", 1.0);
    }
    if (parameters.num_points != 0) {
      if (const auto sampled = AddSamples(solid, parameters.num_points, progress, workers, &object); !sampled) {
        return tl::unexpected(sampled.error());
      }
    }
    return object;
  }
  if (parameters.voxel_size_m != 0.0) {
    auto voxmap = BuildVoxmap(solid, parameters.voxel_size_m, progress);
    if (!voxmap) return tl::unexpected(voxmap.error());
    object.voxmap = std::move(*voxmap);
  }
  if (parameters.num_points != 0) {
    const auto shell = BuildPointshell(solid, parameters.num_points, progress, workers);
    if (!shell) return tl::unexpected(shell.error());
    if (progress) progress("point-sphere tree", 0.0);
    object.points = BuildTree(*shell);
    if (progress) progress("point-sphere tree", 1.0);
  }
  return object;
}

}  // namespace

core::Result<CookedObject> Cook(const TriangleMesh& mesh, const CookParameters& parameters, const Progress& progress,
                                core::ParallelFor* workers) {
  if (mesh.triangles.empty()) return core::Fail(core::ErrorCode::kInvalidInput, "the mesh has no triangles");
  if (const auto good = CheckSheetThickness(parameters); !good) return tl::unexpected(good.error());
  if (parameters.sheet_half_thickness_m > 0.0) {
    return Build(ThickenSheet(mesh, 2.0 * parameters.sheet_half_thickness_m), parameters, progress, workers);
  }
  if (IsInsideOut(mesh)) {
    return core::Fail(core::ErrorCode::kInvalidInput, "the mesh is inside out: turn its faces over");
  }
  return Build(mesh, parameters, progress, workers);
}

namespace {

// A mesh file in one role, as it is cached: a part that is a field here, and there is sampled too, is built once.
struct Role {
  CookParameters parameters;
  std::filesystem::path file{};
  std::uint64_t key = 0;
  core::Result<CookedObject> object = {};
};

std::vector<Role> RolesOf(const CookParameters& parameters) {
  std::vector<Role> roles;
  if (parameters.voxel_size_m != 0.0 || parameters.num_points == 0) {
    roles.push_back({parameters});
    roles.back().parameters.num_points = 0;
  }
  if (parameters.num_points != 0) {
    roles.push_back({parameters});
    roles.back().parameters.voxel_size_m = 0.0;
  }
  return roles;
}

void Add(CookedObject&& role, CookedObject* object) {
  if (role.voxmap) object->voxmap = std::move(role.voxmap);
  if (role.field) object->field = std::move(role.field);
  if (role.bends) object->bends = std::move(role.bends);
  if (role.points) object->points = std::move(role.points);
  if (role.samples) {
    object->samples = std::move(role.samples);
    object->coarser = std::move(role.coarser);
  }
  if (role.surface) object->surface = std::move(role.surface);
  object->bounding_centre_m = role.bounding_centre_m;
  object->bounding_radius_m = role.bounding_radius_m;
  object->is_from_cache = object->is_from_cache && role.is_from_cache;
  if (object->cache_note.empty()) object->cache_note = std::move(role.cache_note);
}

}  // namespace

core::Result<CookedObject> Cook(const std::filesystem::path& mesh_file, const CookParameters& parameters,
                                const std::filesystem::path& cache_folder, const Progress& progress,
                                core::ParallelFor* workers) {
  const auto triangles = LoadTriangles(mesh_file);
  if (!triangles) return tl::unexpected(triangles.error());
  // Hashed are the loaded triangles, not the file's bytes: a .gltf may keep its vertices in another file.
  const std::uint64_t mesh_hash = HashOf(*triangles);
  std::vector<Role> roles = RolesOf(parameters);
  bool is_cached = true;
  for (Role& role : roles) {
    role.key = CookedKey(&mesh_hash, sizeof(mesh_hash), role.parameters);
    char digits[17];
    std::snprintf(digits, sizeof(digits), "%016llx", static_cast<unsigned long long>(role.key));
    role.file = (cache_folder.empty() ? DefaultCacheFolder() : cache_folder) /
                (mesh_file.stem().string() + "-" + digits + ".vps");
    role.object = ReadCookedFile(role.file, role.key);
    is_cached = is_cached && role.object;
  }
  std::optional<CheckedMesh> mesh;
  if (!is_cached) {
    auto checked = CheckMesh(*triangles, parameters.sheet_half_thickness_m > 0.0, workers);
    if (!checked) return core::Fail(checked.error().code, mesh_file.string() + ": the mesh " + checked.error().detail);
    if (const auto good = CheckPartSize(mesh_file.string(), checked->report.box); !good) {
      return tl::unexpected(good.error());
    }
    mesh = std::move(*checked);
  }
  CookedObject object;
  object.is_from_cache = is_cached;
  for (Role& role : roles) {
    if (!role.object) {
      auto built = Cook(mesh->mesh, role.parameters, progress, workers);
      if (!built) return core::Fail(built.error().code, mesh_file.string() + ": " + built.error().detail);
      if (role.object.error().code == core::ErrorCode::kDamaged) {
        built->cache_note = role.object.error().detail + "; built anew";
      }
      // Without a cache the next start is slower, nothing else.
      if (const auto written = WriteCookedFile(role.file, role.key, *built); !written) {
        built->cache_note = written.error().detail;
      }
      role.object = std::move(built);
    }
    Add(std::move(*role.object), &object);
  }
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
