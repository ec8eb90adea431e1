#include "vps/voxmap/build_voxmap.hpp"

#include <array>
#include <cmath>
#include <string>

#include "vps/voxmap/distance_transform.hpp"
#include "vps/voxmap/surface_voxels.hpp"

namespace vps {
namespace {

constexpr std::uint8_t kUnknown = 0;
constexpr std::uint8_t kSurface = 1;
constexpr std::uint8_t kOutside = 2;

// Marks what can be reached from voxel (0,0,0) through faces of voxels that are not surface, a run along x at a time.
// Conservative surface voxels leave no gap between face neighbours, so a closed surface does not leak.
void FloodOutside(const Voxmap& grid, std::vector<std::uint8_t>* state) {
  struct Seed {
    std::int32_t x, y, z;
  };
  const auto row_of = [&](int y, int z) {
    return state->data() + (static_cast<std::size_t>(z) * grid.ny + y) * grid.nx;
  };
  std::vector<Seed> seeds{{0, 0, 0}};
  while (!seeds.empty()) {
    const Seed seed = seeds.back();
    seeds.pop_back();
    std::uint8_t* row = row_of(seed.y, seed.z);
    if (row[seed.x] != kUnknown) continue;
    int first = seed.x;
    int last = seed.x;
    while (first > 0 && row[first - 1] == kUnknown) --first;
    while (last + 1 < grid.nx && row[last + 1] == kUnknown) ++last;
    std::fill(row + first, row + last + 1, kOutside);
    constexpr int kSteps[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    for (const auto& step : kSteps) {
      const int y = seed.y + step[0];
      const int z = seed.z + step[1];
      if (y < 0 || z < 0 || y >= grid.ny || z >= grid.nz) continue;
      const std::uint8_t* neighbour = row_of(y, z);
      for (int x = first; x <= last; ++x) {
        const bool starts_run = neighbour[x] == kUnknown && (x == first || neighbour[x - 1] != kUnknown);
        if (starts_run) seeds.push_back({x, y, z});
      }
    }
  }
}

}  // namespace

core::Result<Voxmap> BuildVoxmap(const TriangleMesh& mesh, double voxel_size_m,
                                 const std::function<void(std::string_view, double)>& progress) {
  const auto report = [&](std::string_view stage, double fraction) {
    if (progress) progress(stage, fraction);
  };
  if (!(voxel_size_m > 0.0) || !std::isfinite(voxel_size_m)) {
    return core::Fail(core::ErrorCode::kInvalidInput, "voxel size must be a positive number of metres");
  }
  if (mesh.triangles.empty()) return core::Fail(core::ErrorCode::kInvalidInput, "the mesh has no triangles");
  const Box box = BoundingBox(mesh);
  Voxmap grid;
  grid.voxel_size_m = voxel_size_m;
  grid.border_layers = static_cast<std::int32_t>(std::clamp(
      std::ceil(Voxmap::kBorder_m / voxel_size_m), double(Voxmap::kMinBorderLayers), double(Voxmap::kMaxBorderLayers)));
  grid.origin_m = box.lower - (grid.border_layers + 0.5) * voxel_size_m;
  const glm::dvec3 counts = glm::floor((box.upper - grid.origin_m) / voxel_size_m) + double(grid.border_layers + 1);
  if (!(counts.x * counts.y * counts.z <= static_cast<double>(kMaxVoxels))) {
    return core::Fail(core::ErrorCode::kResource,
                      "a voxel of " + std::to_string(voxel_size_m * 1e3) + " mm takes " +
                          std::to_string(counts.x * counts.y * counts.z / 1e6) +
                          " million voxels, more than 1000; take larger voxels or split the object");
  }
  grid.nx = static_cast<std::int32_t>(counts.x);
  grid.ny = static_cast<std::int32_t>(counts.y);
  grid.nz = static_cast<std::int32_t>(counts.z);
  const std::size_t num_voxels = static_cast<std::size_t>(grid.nx) * grid.ny * grid.nz;

  report("voxels: surface", 0.0);
  std::vector<std::uint8_t> state(num_voxels, kUnknown);
  MarkSurface(mesh, grid, kSurface, state.data());
  report("voxels: outside", 0.0);
  FloodOutside(grid, &state);
  const std::vector<std::uint16_t> squared = SquaredDistances(
      state, kSurface, grid.nx, grid.ny, grid.nz, [&](double fraction) { report("voxels: layers", fraction); });

  std::array<std::int8_t, kDistanceLimit * kDistanceLimit + 1> layer_of{};
  for (std::size_t d2 = 0; d2 < layer_of.size(); ++d2) {
    layer_of[d2] = static_cast<std::int8_t>(
        std::min<long>(std::lround(std::sqrt(static_cast<double>(d2))), static_cast<long>(Voxmap::kMaxLayer)));
  }
  grid.layers.resize(num_voxels);
  for (std::size_t i = 0; i < num_voxels; ++i) {
    const std::int8_t layer = layer_of[squared[i]];
    grid.layers[i] = state[i] == kOutside ? static_cast<std::int8_t>(-layer) : layer;
  }
  report("voxels: layers", 1.0);
  return grid;
}

}  // namespace vps
