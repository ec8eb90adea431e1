#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "core/clock.hpp"
#include "tools/oos/verb.hpp"
#include "vps/asset/cooked_object.hpp"

namespace oos {
namespace {

int CookOne(const std::string& mesh, const vps::CookParameters& parameters) {
  const bool is_terminal = isatty(STDOUT_FILENO) != 0;
  std::string last_stage;
  const auto progress = [&](std::string_view stage, double fraction) {
    if (is_terminal) {
      std::printf("\r%s: %-24.*s %3.0f %%", mesh.c_str(), static_cast<int>(stage.size()), stage.data(),
                  100.0 * fraction);
      std::fflush(stdout);
    } else if (stage != last_stage) {
      last_stage = stage;
      std::printf("%s: %s\n", mesh.c_str(), last_stage.c_str());
    }
  };
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  const auto cooked = vps::Cook(mesh, parameters, {}, progress);
  if (is_terminal) std::printf("\r\033[K");
  if (!cooked) return Complain("cook", cooked.error().detail, kBadUsage);
  const double seconds = static_cast<double>(core::MonotonicNow_ns() - begin_ns) * 1e-9;
  std::printf("%s: %s in %.2f s, bounding radius %.4f m\n", mesh.c_str(),
              cooked->is_from_cache ? "taken from the cache" : "built", seconds, cooked->bounding_radius_m);
  if (cooked->voxmap) {
    const vps::Voxmap& map = *cooked->voxmap;
    std::printf("  voxelmap: %d x %d x %d voxels of %.3g mm, %.1f MB\n", map.nx, map.ny, map.nz, 1e3 * map.voxel_size_m,
                static_cast<double>(map.num_voxels()) * 1e-6);
  }
  if (cooked->field) {
    const vps::DistanceField& field = *cooked->field;
    std::printf("  distance field: %d x %d x %d voxels of %.3g mm, %zu bricks, %zu crease cells, %.1f MB\n", field.nx,
                field.ny, field.nz, 1e3 * field.voxel_size_m, field.words.size() / vps::DistanceField::kBrickWords,
                field.creases.size() / vps::kPlanesPerCrease, static_cast<double>(field.num_bytes()) * 1e-6);
  }
  if (cooked->samples) {
    std::printf("  samples: %u points on %.4g m2, %.1f MB\n", cooked->samples->num_points, cooked->samples->area_m2,
                static_cast<double>(cooked->samples->num_bytes()) * 1e-6);
  }
  if (cooked->points) {
    const vps::PointTree& tree = *cooked->points;
    const std::size_t num_bytes = tree.x.size() * 6 * sizeof(float) + tree.clusters.size() * sizeof(vps::Cluster);
    std::printf("  pointshell: %u points in %zu clusters, %.1f MB\n", tree.num_points, tree.clusters.size(),
                static_cast<double>(num_bytes) * 1e-6);
  }
  return kHolds;
}

int Run(const Arguments& arguments) {
  const auto voxel = arguments.number("--voxel_m");
  const auto points = arguments.number("--points");
  if (!voxel) return Complain("cook", voxel.error().detail, kBadUsage);
  if (!points) return Complain("cook", points.error().detail, kBadUsage);
  vps::CookParameters parameters;
  parameters.voxel_size_m = voxel->value_or(0.0);
  parameters.num_points = static_cast<std::uint32_t>(points->value_or(0.0));
  const std::string method = arguments.text("--method", "paper");
  if (!vps::MethodFromName(method)) {
    return Complain("cook", "--method is paper or fast, not '" + method + "'", kBadUsage);
  }
  parameters.method = *vps::MethodFromName(method);
  if (parameters.voxel_size_m <= 0.0 && parameters.num_points == 0) {
    return Complain("cook", "nothing to build: give --voxel_m, --points or both", kBadUsage);
  }
  int status = kHolds;
  for (const std::string& mesh : arguments.positional()) status = std::max(status, CookOne(mesh, parameters));
  std::printf("cache: %s\n", vps::DefaultCacheFolder().c_str());
  return status;
}

}  // namespace

Verb CookVerb() {
  return {"cook",
          "builds a mesh's voxelmap and pointshell and keeps them in the cache",
          "MESH...",
          1,
          1000,
          {{"--voxel_m", "SIZE", "edge of a voxel, m; none: no field side"},
           {"--points", "N", "points on the surface; none: no sampled side"},
           {"--method", "paper|fast", "whose structures; default: paper"}},
          Run};
}

}  // namespace oos
