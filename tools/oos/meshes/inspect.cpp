#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include "collision/resolution/choose_resolutions.hpp"
#include "tools/inspect/samples_picture.hpp"
#include "tools/inspect/slices.hpp"
#include "tools/oos/meshes/mesh_lines.hpp"
#include "tools/oos/meshes/verbs.hpp"
#include "tools/oos/verb/find_scenario.hpp"
#include "vps/asset/feature_size.hpp"
#include "vps/mesh/part_size.hpp"
#include "vps/mesh/thicken_sheet.hpp"

namespace oos {
namespace {

constexpr std::string_view kInspectDetails =
    R"(Writes to DIR, for each method:
  METHOD_slices.png   three slices of the distance and a close-up where the part is thinnest or narrowest: colour and
                      iso-lines, the surface bold, crease cells, brick borders
  METHOD_points.png   the sampled points from four sides; fast: coloured by the area that each stands for
  METHOD_tree.png     the spheres of each level of the tree over the points
An object is named SCENARIO:NAME, e.g. scenarios/touch:plate, and shown with its own voxels and points, where it has
them.)";

struct Request {
  std::filesystem::path mesh_file;
  double scale = 1.0;
  double voxel_size_m = 0.0;
  std::uint32_t num_points = 0;
  double sheet_thickness_m = 0.0;
};

core::Result<double> Positive(const Arguments& arguments, std::string_view name, double fallback) {
  const auto value = arguments.number(name);
  if (!value) return tl::unexpected(value.error());
  if (value->has_value() && !(**value > 0.0 && std::isfinite(**value))) {
    return core::Fail(core::ErrorCode::kInvalidInput, std::string(name) + " must be greater than 0");
  }
  return value->value_or(fallback);
}

// A mesh file, or SCENARIO:NAME.
core::Result<Request> FindObject(const std::string& what) {
  Request request;
  std::error_code error;
  const std::size_t colon = what.rfind(':');
  if (std::filesystem::exists(what, error) || colon == std::string::npos) {
    request.mesh_file = what;
    return request;
  }
  const auto scenario = collision::LoadResolvedScenario(FindScenario(what.substr(0, colon)));
  if (!scenario) return core::Fail(core::ErrorCode::kInvalidInput, scene::Format(scenario.error().front()));
  std::string known;
  for (const scene::Object& object : scenario->objects) {
    known += " " + object.name;
    if (object.name != what.substr(colon + 1)) continue;
    request.mesh_file = object.collision_mesh.empty() ? object.visual_mesh : object.collision_mesh;
    request.voxel_size_m = object.voxel_size_m;
    request.num_points = object.num_points;
    request.sheet_thickness_m = object.sheet_thickness_m;
    return request;
  }
  return core::Fail(core::ErrorCode::kNotFound, what + ": no such object; known:" + known);
}

core::Result<Request> ReadRequest(const Arguments& arguments) {
  auto request = FindObject(arguments.positional()[0]);
  if (!request) return request;
  const auto scale = Positive(arguments, "--scale", 1.0);
  const auto voxel = Positive(arguments, "--voxel_m", request->voxel_size_m);
  const auto points = Positive(arguments, "--points", request->num_points);
  const auto sheet = Positive(arguments, "--sheet_thickness_m", request->sheet_thickness_m);
  for (const auto* value : {&scale, &voxel, &points, &sheet}) {
    if (!*value) return tl::unexpected(value->error());
  }
  request->scale = *scale;
  request->voxel_size_m = *voxel;
  request->num_points = static_cast<std::uint32_t>(std::min(*points, 4e6));
  request->sheet_thickness_m = *sheet;
  return request;
}

// By default 1/128 of the longest side (a sheet: a quarter of its thickness at most), and points two voxels apart.
void FillResolution(const vps::CheckedMesh& checked, Request* request) {
  if (request->voxel_size_m <= 0.0) {
    request->voxel_size_m = vps::LongestSide_m(checked.report.box) / 128.0;
    if (request->sheet_thickness_m > 0.0) {
      request->voxel_size_m = std::min(request->voxel_size_m, request->sheet_thickness_m / 4.0);
    }
  }
  if (request->num_points != 0) return;
  const double wanted = checked.report.area_m2 / (4.0 * request->voxel_size_m * request->voxel_size_m);
  request->num_points = static_cast<std::uint32_t>(std::clamp(wanted, 500.0, 40'000.0));
}

core::Result<void> WritePictures(vps::Method method, const vps::CheckedMesh& checked, const Request& request,
                                 const inspect::CloseUp& close_up, const std::filesystem::path& folder) {
  const std::string name = method == vps::Method::kFast ? "fast" : "paper";
  const auto cooked =
      vps::Cook(checked.mesh, {request.voxel_size_m, request.num_points, method, 0.5 * request.sheet_thickness_m});
  if (!cooked) return core::Fail(cooked.error().code, request.mesh_file.string() + ": " + cooked.error().detail);
  const bool is_fast = method == vps::Method::kFast;
  vps::Box box = checked.report.box;
  box.lower -= 0.5 * request.sheet_thickness_m;
  box.upper += 0.5 * request.sheet_thickness_m;
  const auto points = is_fast ? vps::PointsOf(*cooked->samples) : vps::PointsOf(*cooked->points);
  const auto levels = is_fast ? vps::LevelsOf(*cooked->samples) : vps::LevelsOf(*cooked->points);
  const auto field = is_fast ? inspect::ViewOf(*cooked->field) : inspect::ViewOf(*cooked->voxmap);
  const auto write = [&](const core::Result<picture::Image>& image, const char* what) -> core::Result<void> {
    if (!image) return tl::unexpected(image.error());
    const std::filesystem::path file = folder / (name + "_" + what + ".png");
    if (const auto written = picture::WritePng(*image, file); !written) return written;
    std::printf("%s\n", file.c_str());
    return {};
  };
  if (const auto done = write(inspect::DrawSlices(field, box, close_up), "slices"); !done) return done;
  const std::string title = is_fast ? "samples of fast" : "pointshell of paper";
  if (const auto done = write(inspect::DrawPoints(title, points, box), "points"); !done) return done;
  return write(inspect::DrawTree("sphere tree of " + name, levels, points, box), "tree");
}

int RunInspect(const Arguments& arguments) {
  const auto fail = [](const core::Error& error) { return Complain("inspect", error.detail, kBadUsage); };
  if (!arguments.has("--out")) return Complain("inspect", "--out DIR is missing", kBadUsage);
  const std::string method = arguments.text("--method", "both");
  if (method != "both" && !vps::MethodFromName(method)) {
    return Complain("inspect", "--method is paper, fast or both, not '" + method + "'", kBadUsage);
  }
  auto request = ReadRequest(arguments);
  if (!request) return fail(request.error());
  const auto checked = vps::LoadCheckedMesh(request->mesh_file, request->scale, request->sheet_thickness_m > 0.0);
  if (!checked) return fail(checked.error());
  if (!arguments.has("--scale")) {
    const auto good = vps::CheckPartSize(request->mesh_file.string(), checked->report.box);
    if (!good) return fail(good.error());
  }
  FillResolution(*checked, &*request);
  PrintMesh(request->mesh_file.string(), checked->report);
  const vps::FeatureSize size = vps::MeasureFeatures(
      request->sheet_thickness_m > 0.0 ? vps::ThickenSheet(checked->mesh, request->sheet_thickness_m) : checked->mesh);
  PrintFeatures(size);
  inspect::CloseUp close_up{checked->mesh.corners(0)[0], {0.0, 0.0, 1.0}};
  if (std::isfinite(size.thickness_m)) close_up = {size.thinnest_m, size.thinnest_normal};
  if (size.gap_m < size.thickness_m) close_up = {size.narrowest_m, size.narrowest_normal};
  for (const vps::Method each : {vps::Method::kPaper, vps::Method::kFast}) {
    if (method != "both" && *vps::MethodFromName(method) != each) continue;
    const auto done = WritePictures(each, *checked, *request, close_up, arguments.text("--out"));
    if (!done) return fail(done.error());
  }
  return kHolds;
}

}  // namespace

Verb InspectVerb() {
  return {"inspect",
          "draws the structures built from a mesh: slices of the field, points, sphere tree",
          "MESH|SCENARIO:OBJECT --out DIR",
          1,
          1,
          {{"--out", "DIR", "folder of the pictures"},
           {"--method", "paper|fast|both", "whose structures; default: both"},
           {"--voxel_m", "SIZE", "edge of a voxel, m; default 1/128 of the longest side"},
           {"--points", "N", "points on the surface; default: two voxels apart"},
           {"--scale", "S", "factor of the mesh's coordinates, 0.001 for millimetres; default 1"},
           {"--sheet_thickness_m", "T", "takes the mesh as a sheet with two sides, T thick"}},
          RunInspect,
          kInspectDetails};
}

}  // namespace oos
