#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "bus/rt/worker_pool.hpp"
#include "collision/resolution/choose_resolutions.hpp"
#include "core/clock.hpp"
#include "scene/load_scenario.hpp"
#include "tools/oos/meshes/mesh_lines.hpp"
#include "tools/oos/meshes/progress_line.hpp"
#include "tools/oos/meshes/verbs.hpp"
#include "tools/oos/verb/find_scenario.hpp"
#include "vps/asset/cooked_object.hpp"
#include "vps/field/build_field.hpp"
#include "vps/mesh/part_size.hpp"
#include "vps/mesh/thicken_sheet.hpp"

namespace oos {
namespace {

constexpr std::string_view kCookDetails =
    R"(Of each mesh: what is wrong with it and what was repaired (places in the mesh's own frame; triangles counted from 0),
its thinnest wall and narrowest gap, what voxels of this size show of them, the memory that the build will take (before
it takes it), and what was built. SCENARIO cooks every object that stands in a pair, with the scenario's own figures; of
those that it leaves open, what was chosen and why.)";

struct Job {
  std::string title;
  std::filesystem::path mesh;
  vps::CookParameters parameters;
  std::vector<std::string> chosen;  // of a resolution that the scenario leaves open: what, and why
};

void PrintParts(const vps::CookedObject& cooked) {
  if (cooked.voxmap) {
    const vps::Voxmap& map = *cooked.voxmap;
    std::printf("  voxelmap: %d x %d x %d voxels of %.3g mm, %.1f MB\n", map.nx, map.ny, map.nz, 1e3 * map.voxel_size_m,
                static_cast<double>(map.num_voxels()) * 1e-6);
  }
  if (cooked.field) {
    const vps::DistanceField& field = *cooked.field;
    std::printf("  distance field: %d x %d x %d voxels of %.3g mm, %zu bricks, %zu crease cells, %.1f MB\n", field.nx,
                field.ny, field.nz, 1e3 * field.voxel_size_m, field.words.size() / vps::DistanceField::kBrickWords,
                field.creases.size() / vps::kPlanesPerCrease, static_cast<double>(field.num_bytes()) * 1e-6);
  }
  if (cooked.samples) {
    const vps::SampleTree& tree = *cooked.samples;
    std::printf("  samples: %u points on %.4g m2, %.3g mm apart, %.1f MB\n", tree.num_points, tree.area_m2,
                1e3 * std::sqrt(tree.area_m2 / tree.num_points), static_cast<double>(tree.num_bytes()) * 1e-6);
  }
  if (cooked.points) {
    const vps::PointTree& tree = *cooked.points;
    const std::size_t num_bytes = tree.x.size() * 6 * sizeof(float) + tree.clusters.size() * sizeof(vps::Cluster);
    std::printf("  pointshell: %u points in %zu clusters, %.1f MB\n", tree.num_points, tree.clusters.size(),
                static_cast<double>(num_bytes) * 1e-6);
  }
}

void PrintBytes(const char* what, double stored, double peak) {
  std::printf("  memory: %s %.3g MB, %.3g MB while it is built\n", what, 1e-6 * stored, 1e-6 * peak);
}

// Before anything is built. A voxelmap takes a byte for each voxel, and three more while it is built.
// `solid`: of a sheet, what it is thickened to; else the mesh.
core::Result<void> PrintMemory(const vps::TriangleMesh& solid, const vps::Box& box,
                               const vps::CookParameters& parameters) {
  if (parameters.method == vps::Method::kFast && parameters.num_points > 0) {
    const auto estimate = vps::EstimateSampleTree(solid, parameters.num_points);
    if (!estimate) return tl::unexpected(estimate.error());
    // Coarser ones too: a quarter of them, a sixteenth ... Two levels are made at once, and the panels of a finely
    // tessellated mesh are as many at every level.
    PrintBytes("samples", 4.0 / 3.0 * estimate->stored_bytes, 2.0 * estimate->peak_bytes);
  }
  if (parameters.voxel_size_m <= 0.0) return {};
  if (parameters.method == vps::Method::kFast) {
    const auto estimate = vps::EstimateField(solid, parameters.voxel_size_m);
    if (!estimate) return tl::unexpected(estimate.error());
    PrintBytes("distance field", estimate->stored_bytes, estimate->peak_bytes);
    return {};
  }
  const double border = std::clamp(std::ceil(vps::Voxmap::kBorder_m / parameters.voxel_size_m),
                                   double(vps::Voxmap::kMinBorderLayers), double(vps::Voxmap::kMaxBorderLayers));
  const glm::dvec3 counts = glm::floor((box.upper - box.lower) / parameters.voxel_size_m) + 2.0 * border + 2.0;
  const double num_voxels = counts.x * counts.y * counts.z;
  PrintBytes("voxelmap", num_voxels, 4.0 * num_voxels);
  return {};
}

int CookOne(const Job& job) {
  const double sheet_thickness_m = 2.0 * job.parameters.sheet_half_thickness_m;
  const auto checked = vps::LoadCheckedMesh(job.mesh, 1.0, sheet_thickness_m > 0.0);
  if (!checked) return Complain("cook", checked.error().detail, kBadUsage);
  if (const auto good = vps::CheckPartSize(job.mesh.string(), checked->report.box); !good) {
    return Complain("cook", good.error().detail, kBadUsage);
  }
  PrintMesh(job.title, checked->report);
  for (const std::string& text : job.chosen) std::printf("  chosen: %s\n", text.c_str());
  const vps::TriangleMesh solid =
      sheet_thickness_m > 0.0 ? vps::ThickenSheet(checked->mesh, sheet_thickness_m) : checked->mesh;
  const vps::FeatureSize size = vps::MeasureFeatures(solid);
  PrintFeatures(size);
  if (job.parameters.voxel_size_m > 0.0) {
    PrintLimits(size, vps::LimitsOf(job.parameters.method, job.parameters.voxel_size_m));
  }
  if (const auto printed = PrintMemory(solid, checked->report.box, job.parameters); !printed) {
    return Complain("cook", job.mesh.string() + ": " + printed.error().detail, kBadUsage);
  }
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  const auto cooked = [&] {
    ProgressLine line(job.title, stdout, true);
    bus::WorkerPool workers(NumCookWorkers(), "cook");
    return vps::Cook(job.mesh, job.parameters, {}, line.AsProgress(), &workers);
  }();
  if (!cooked) return Complain("cook", cooked.error().detail, kBadUsage);
  const double seconds = static_cast<double>(core::MonotonicNow_ns() - begin_ns) * 1e-9;
  if (!cooked->cache_note.empty()) std::printf("  warning: %s\n", cooked->cache_note.c_str());
  std::printf("  %s in %.2f s, bounding radius %.4f m\n", cooked->is_from_cache ? "taken from the cache" : "built",
              seconds, cooked->bounding_radius_m);
  PrintParts(*cooked);
  return kHolds;
}

// The structures of every object that its contact pairs need.
core::Result<std::vector<Job>> JobsOf(const std::string& path, std::optional<vps::Method> method) {
  auto scenario = scene::LoadScenario(path);
  if (!scenario) return core::Fail(core::ErrorCode::kInvalidInput, scene::Format(scenario.error().front()));
  if (method) scenario->method = *method == vps::Method::kFast ? "fast" : "paper";
  const auto notes = collision::ChooseResolutions(&*scenario);
  if (!notes) return core::Fail(core::ErrorCode::kInvalidInput, scene::Format(notes.error().front()));
  std::vector<Job> jobs;
  for (std::size_t i = 0; i < scenario->objects.size(); ++i) {
    const scene::Object& object = scenario->objects[i];
    Job job{object.name + " (" + object.collision_mesh.filename().string() + ")", object.collision_mesh, {}, {}};
    job.parameters.method = *vps::MethodFromName(scenario->method);
    job.parameters.sheet_half_thickness_m = 0.5 * object.sheet_thickness_m;
    for (const scene::Pair& pair : scenario->pairs) {
      if (pair.field == i) job.parameters.voxel_size_m = object.voxel_size_m;
      if (pair.sampled == i) job.parameters.num_points = object.num_points;
    }
    for (const collision::ResolutionNote& note : *notes) {
      if (note.object == i) job.chosen.push_back(note.text);
    }
    if (job.parameters.voxel_size_m > 0.0 || job.parameters.num_points > 0) jobs.push_back(job);
  }
  return jobs;
}

core::Result<vps::CookParameters> ReadParameters(const Arguments& arguments) {
  vps::CookParameters parameters;
  const auto voxel = arguments.number("--voxel_m");
  const auto points = arguments.number("--points");
  const auto sheet = arguments.number("--sheet_thickness_m");
  for (const auto* value : {&voxel, &points, &sheet}) {
    if (!*value) return tl::unexpected(value->error());
    if (!((*value)->value_or(0.0) >= 0.0 && (*value)->value_or(0.0) <= 4e9)) {
      return core::Fail(core::ErrorCode::kInvalidInput, "--voxel_m, --points and --sheet_thickness_m are above 0");
    }
  }
  if (points->value_or(0.0) != std::floor(points->value_or(0.0))) {
    return core::Fail(core::ErrorCode::kInvalidInput, "--points must be a whole number");
  }
  parameters.voxel_size_m = voxel->value_or(0.0);
  parameters.num_points = static_cast<std::uint32_t>(points->value_or(0.0));
  parameters.sheet_half_thickness_m = 0.5 * sheet->value_or(0.0);
  return parameters;
}

// None: a scenario's own, and fast for a mesh.
core::Result<std::optional<vps::Method>> ReadMethod(const Arguments& arguments) {
  const std::string name = arguments.text("--method", "");
  if (name.empty()) return std::optional<vps::Method>{};
  const auto method = vps::MethodFromName(name);
  if (method) return method;
  return core::Fail(core::ErrorCode::kInvalidInput, "--method is paper or fast, not '" + name + "'");
}

int RunCook(const Arguments& arguments) {
  auto parameters = ReadParameters(arguments);
  if (!parameters) return Complain("cook", parameters.error().detail, kBadUsage);
  const auto method = ReadMethod(arguments);
  if (!method) return Complain("cook", method.error().detail, kBadUsage);
  parameters->method = method->value_or(vps::Method::kFast);
  int status = kHolds;
  for (const std::string& given : arguments.positional()) {
    const std::string path = FindScenario(given).string();
    std::error_code error;
    if (std::filesystem::is_directory(path, error) || std::filesystem::path(path).extension() == ".xml") {
      const auto jobs = JobsOf(path, *method);
      if (!jobs) return Complain("cook", jobs.error().detail, kBadUsage);
      for (const Job& job : *jobs) status = std::max(status, CookOne(job));
      continue;
    }
    if (parameters->voxel_size_m <= 0.0 && parameters->num_points == 0) {
      return Complain("cook", "nothing to build: give --voxel_m, --points or both", kBadUsage);
    }
    status = std::max(status, CookOne({path, path, *parameters, {}}));
  }
  std::printf("cache: %s\n", vps::DefaultCacheFolder().c_str());
  return status;
}

}  // namespace

Verb CookVerb() {
  return {"cook",
          "checks meshes, builds their collision structures and stores them in the cache",
          "MESH|SCENARIO...",
          1,
          1000,
          {{"--voxel_m", "SIZE", "edge of a voxel, m; none: no field side"},
           {"--points", "N", "points on the surface; none: no sampled side"},
           {"--sheet_thickness_m", "T", "the mesh is a sheet with two sides, T thick"},
           {"--method", "paper|fast", "whose structures; default: the scenario's, of a mesh fast"}},
          RunCook,
          kCookDetails};
}

}  // namespace oos
