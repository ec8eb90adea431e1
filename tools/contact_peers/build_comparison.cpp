#include "tools/contact_peers/build_comparison.hpp"

#include <malloc.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/MeshToVolume.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>

#include "bus/rt/worker_pool.hpp"
#include "core/clock.hpp"
#include "vps/field/build_field.hpp"
#include "vps/mesh/load_mesh.hpp"
#include "vps/testing/shapes.hpp"

namespace contact_peers {
namespace {

constexpr int kRepetitions = 3;                  // the median of three leaves out one disturbed run; not derived
constexpr int kMmapThresholdBytes = 128 * 1024;  // glibc's default, which it otherwise raises as large blocks are freed

// A line of /proc/self/status, which is in kB, in bytes.
double StatusBytes(const char* name) {
  std::ifstream in("/proc/self/status");
  std::string line;
  while (std::getline(in, line)) {
    if (line.rfind(name, 0) == 0) return std::atof(line.c_str() + line.find(':') + 1) * 1024.0;
  }
  return 0.0;
}

struct Cost {
  double time_s = 0.0, stored_bytes = 0.0, peak_bytes = 0.0;
};

// `build` builds, frees the result, and returns the size that it had [bytes].
Cost Measure(const std::function<double()>& build) {
  malloc_trim(0);
  const double before = StatusBytes("VmRSS");
  std::ofstream("/proc/self/clear_refs") << "5";  // resets VmHWM, the peak
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  Cost cost;
  cost.stored_bytes = build();
  cost.time_s = static_cast<double>(core::MonotonicNow_ns() - begin_ns) * 1e-9;
  cost.peak_bytes = StatusBytes("VmHWM") - before;
  return cost;
}

double BuildFast(const vps::TriangleMesh& mesh, double voxel_size_m, core::ParallelFor* workers) {
  const auto field = vps::BuildField(mesh, voxel_size_m, {.workers = workers});
  return field ? static_cast<double>(field->num_bytes()) : 0.0;
}

double BuildOpenvdb(const std::vector<openvdb::Vec3s>& points, const std::vector<openvdb::Vec3I>& triangles,
                    double voxel_size_m) {
  const auto transform = openvdb::math::Transform::createLinearTransform(voxel_size_m);
  const auto grid = openvdb::tools::meshToLevelSet<openvdb::FloatGrid>(*transform, points, triangles,
                                                                       vps::DistanceField::kBandVoxels);
  return static_cast<double>(grid->memUsage());
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

constexpr const char* kMethods[] = {"fast", "OpenVDB"};
constexpr const char* kBlock = "block_with_hole";

core::Result<vps::TriangleMesh> MeshCalled(const std::string& name, const std::filesystem::path& meshes) {
  if (name == kBlock) return vps::MakeBlockWithHole(0.05, 0.05, 0.01025, 128);
  return vps::LoadMesh(meshes / (name + ".obj"));
}

Cost MeasureBuild(const std::string& method, const vps::TriangleMesh& mesh, int voxels, int threads) {
  const vps::Box box = vps::BoundingBox(mesh);
  const glm::dvec3 size = box.upper - box.lower;
  const double voxel_size_m = std::max({size.x, size.y, size.z}) / voxels;
  if (method == kMethods[0]) {
    bus::WorkerPool workers(threads, "build");
    return Measure([&] { return BuildFast(mesh, voxel_size_m, &workers); });
  }
  openvdb::initialize();
  std::vector<openvdb::Vec3s> points;
  for (const glm::dvec3& v : mesh.vertices) points.emplace_back(v.x, v.y, v.z);
  std::vector<openvdb::Vec3I> triangles;
  for (const auto& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  return Measure([&] { return BuildOpenvdb(points, triangles, voxel_size_m); });
}

// In a process of its own: in one that has built before, the allocator reuses freed memory that still counts as
// resident, so that the peak would include the builds before.
core::Result<Cost> MeasureApart(const std::string& method, const std::filesystem::path& meshes, const std::string& mesh,
                                int voxels, int threads) {
  const std::string command = "'" + std::filesystem::read_symlink("/proc/self/exe").string() + "' " + kBuildVerb + " " +
                              method + " '" + meshes.string() + "' " + mesh + " " + std::to_string(voxels) + " " +
                              std::to_string(threads);
  std::FILE* const out = popen(command.c_str(), "r");
  if (out == nullptr) return core::Fail(core::ErrorCode::kResource, "cannot run " + command);
  Cost cost;
  const int count = std::fscanf(out, "%lf %lf %lf", &cost.time_s, &cost.stored_bytes, &cost.peak_bytes);
  if (pclose(out) != 0 || count != 3) return core::Fail(core::ErrorCode::kResource, command + " failed");
  return cost;
}

core::Result<void> Compare(const std::string& name, const std::filesystem::path& meshes, int voxels, int threads,
                           std::vector<BuildMeasurement>* out) {
  std::vector<double> times[2], peaks[2];
  double stored[2] = {0.0, 0.0};
  for (int round = 0; round < kRepetitions; ++round) {
    for (int k = 0; k < 2; ++k) {
      const auto cost = MeasureApart(kMethods[k], meshes, name, voxels, threads);
      if (!cost) return tl::unexpected(cost.error());
      times[k].push_back(cost->time_s);
      peaks[k].push_back(cost->peak_bytes);
      stored[k] = cost->stored_bytes;
    }
  }
  for (int k = 0; k < 2; ++k) {
    out->push_back({name, kMethods[k], voxels, threads, Median(times[k]), stored[k], Median(peaks[k])});
  }
  const BuildMeasurement& own = (*out)[out->size() - 2];
  const BuildMeasurement& vdb = out->back();
  std::printf(
      "%-24s %4d voxels, %d threads: fast %6.2f s, %6.1f MB, peak %6.1f MB; OpenVDB %6.2f s, %6.1f MB, peak "
      "%6.1f MB; %4.2f times as fast\n",
      name.c_str(), voxels, threads, own.time_s, 1e-6 * own.stored_bytes, 1e-6 * own.peak_bytes, vdb.time_s,
      1e-6 * vdb.stored_bytes, 1e-6 * vdb.peak_bytes, vdb.time_s / own.time_s);
  std::fflush(stdout);
  return {};
}

}  // namespace

int BuildOnce(int argc, char** argv) {
  if (argc != 7) return 2;
  const auto mesh = MeshCalled(argv[4], argv[3]);
  if (!mesh) return 1;
  // Fixed, so that large arrays are returned to the kernel when freed, whatever sizes loading the mesh has freed.
  mallopt(M_MMAP_THRESHOLD, kMmapThresholdBytes);
  const Cost cost = MeasureBuild(argv[2], *mesh, std::atoi(argv[5]), std::atoi(argv[6]));
  std::printf("%.9g %.0f %.0f\n", cost.time_s, cost.stored_bytes, cost.peak_bytes);
  return 0;
}

core::Result<std::vector<BuildMeasurement>> CompareBuilds(const std::filesystem::path& meshes) {
  std::vector<BuildMeasurement> out;
  for (const char* name : {kBlock, "stanford_bunny", "factory_nut_m16_tight_subdiv_3x"}) {
    if (!MeshCalled(name, meshes)) continue;
    for (const int voxels : {256, 512}) {
      for (const int threads : {1, 2}) {
        if (auto done = Compare(name, meshes, voxels, threads, &out); !done) return tl::unexpected(done.error());
      }
    }
  }
  return out;
}

}  // namespace contact_peers
