#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "bus/rt/worker_pool.hpp"
#include "core/clock.hpp"
#include "tools/contact/studies.hpp"
#include "vps/mesh/check_mesh.hpp"
#include "vps/mesh/load_mesh.hpp"
#include "vps/testing/part_shapes.hpp"

namespace contact {
namespace {

constexpr std::uint32_t kPoints = 65536;
constexpr double kVoxels = 256.0;  // along the longest side
constexpr int kTurns = 3;
constexpr double kWanted_s = 5.0;

struct CookedMesh {
  std::string name;
  vps::TriangleMesh mesh;
};

// Generated ones of 1e5 triangles, and public ones that are there: a scan, and a gear whose flanks are long thin
// triangles, split to about as many.
std::vector<CookedMesh> MeshesToCook(const Places& places) {
  std::vector<CookedMesh> meshes;
  meshes.push_back({"lumpy ball", vps::MakeLumpyBall(0.05, 0.01, 2e-4, 316, 1)});
  meshes.push_back(
      {"threaded rod",
       vps::MakeThreadedRod(
           {.radius_m = 0.008, .depth_m = 0.0012, .pitch_m = 0.002, .num_turns = 12, .num_segments = 64})});
  const auto load = [&](const char* name, const char* file, bool is_split) {
    const std::filesystem::path path = places.meshes / file;
    if (!std::filesystem::exists(path)) {
      std::printf("skipped %s: no file %s\n", name, path.c_str());
      return;
    }
    const auto mesh = vps::LoadTriangles(path);
    if (mesh) meshes.push_back({name, is_split ? vps::SplitTriangles(*mesh, 0.5) : *mesh});
    if (!mesh) std::printf("skipped %s: %s\n", name, mesh.error().detail.c_str());
  };
  load("bunny", "stanford_bunny.obj", false);
  load("gear", "factory_gear_small_space_5e-4.obj", true);
  return meshes;
}

// Seconds of each part of the work, one for each turn.
struct CookTimes {
  std::vector<double> check, field, samples;
};

// Checks the mesh and builds both roles, each as `oos cook` does. False: refused.
bool CookOnce(const vps::TriangleMesh& given, core::ParallelFor* workers, CookTimes* times) {
  std::int64_t since_ns = core::MonotonicNow_ns();
  const auto lap = [&](std::vector<double>* to) {
    const std::int64_t now_ns = core::MonotonicNow_ns();
    to->push_back(1e-9 * static_cast<double>(now_ns - since_ns));
    since_ns = now_ns;
  };
  const auto checked = vps::CheckMesh(given, false, workers);
  lap(&times->check);
  if (!checked) return false;
  const glm::dvec3 size = checked->report.box.upper - checked->report.box.lower;
  const double voxel_size_m = std::max({size.x, size.y, size.z}) / kVoxels;
  const bool has_field = vps::Cook(checked->mesh, {voxel_size_m, 0, vps::Method::kFast}, {}, workers).has_value();
  lap(&times->field);
  const bool has_samples = vps::Cook(checked->mesh, {0.0, kPoints, vps::Method::kFast}, {}, workers).has_value();
  lap(&times->samples);
  return has_field && has_samples;
}

}  // namespace

void StudyCook(const Places& places, Report* report) {
  Table table{"cook", {"mesh", "triangles", "role", "threads", "seconds"}, {}};
  double worst_s = 0.0;
  std::string worst;
  bool is_all_cooked = true;
  for (const CookedMesh& each : MeshesToCook(places)) {
    CookTimes of[2];
    bus::WorkerPool one(1, "cook");
    bus::WorkerPool two(2, "cook");
    for (int turn = 0; turn < kTurns; ++turn) {
      is_all_cooked = CookOnce(each.mesh, &one, &of[0]) && CookOnce(each.mesh, &two, &of[1]) && is_all_cooked;
    }
    const std::string triangles = std::to_string(each.mesh.triangles.size());
    for (int k = 0; k < 2; ++k) {
      const double seconds[] = {Quantile(of[k].check, 0.5), Quantile(of[k].field, 0.5), Quantile(of[k].samples, 0.5)};
      const double sum_s = seconds[0] + seconds[1] + seconds[2];
      const auto add = [&](const char* role, double s) {
        table.Add({each.name, triangles, role, std::to_string(k + 1), Cell(s)});
      };
      add("check", seconds[0]);
      add("field", seconds[1]);
      add("samples", seconds[2]);
      add("all", sum_s);
      std::printf("%s, %s triangles, %d threads: check %s s, field %s s, samples %s s\n", each.name.c_str(),
                  triangles.c_str(), k + 1, Short(seconds[0]).c_str(), Short(seconds[1]).c_str(),
                  Short(seconds[2]).c_str());
      if (k == 1 && sum_s > worst_s) {
        worst_s = sum_s;
        worst = each.name;
      }
    }
  }
  report->AddGoal(
      "cooking about 1e5 triangles for both roles, 64 k points, 1/256 of the longest side, 2 threads: slowest mesh",
      "<= " + Short(kWanted_s) + " s", Short(worst_s) + " s (" + worst + ")", is_all_cooked && worst_s <= kWanted_s);
  report->tables.push_back(table);
}

}  // namespace contact
