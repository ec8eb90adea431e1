#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "vps/mesh/triangle_mesh.hpp"
#include "vps/sampling/fine_block.hpp"
#include "vps/sampling/surface_samples.hpp"

namespace vps {

// The points of a sphere of level 0 lie also between two planes, `h` on either side of the centre, across the unit
// normal n; h and n are 0 in the other levels and where the points have no common direction.
struct alignas(64) SphereBlock {
  float x[kBlock], y[kBlock], z[kBlock], r[kBlock];  // m; r is padded against rounding
  float nx[kBlock], ny[kBlock], nz[kBlock], h[kBlock];
};

// Surface samples in the order of an implicit tree with sixteen children: point block b holds points 16 b ... 16 b +
// 15, sphere j of level 0 holds point block j, sphere j of level k the sphere block j of level k - 1. The last level is
// one block. Points that share a block are neighbours. Places without a point are filled with points of no area, far
// away.
struct SampleTree {
  static constexpr std::uint32_t kMaxLevels = 7;
  static constexpr float kFarAway_m = 1e6f;

  std::uint32_t num_points = 0;
  double area_m2 = 0.0;
  glm::dvec3 centre_m{0.0};  // sphere around all
  double radius_m = 0.0;
  std::vector<PointBlock> points;
  std::vector<SphereBlock> spheres;                     // level after level
  std::array<std::uint32_t, kMaxLevels> level_begin{};  // first block of each level
  std::uint32_t num_levels = 0;
  std::vector<FineBlock> fine;  // of each point, in their order; empty: the points are as fine as it gets
  double refined_m = 0.0;       // a sample farther than this from the other body is not taken finer; of a typical patch
  double reach_m = 0.0;         // no place of the surface is farther from the point that stands for it
  std::vector<SampleTree> coarser;  // the same surface in a quarter of the points, in a sixteenth, ...: LevelWalk

  [[nodiscard]] std::size_t num_bytes() const {
    std::size_t sum =
        points.size() * sizeof(PointBlock) + spheres.size() * sizeof(SphereBlock) + fine.size() * sizeof(FineBlock);
    for (const SampleTree& tree : coarser) sum += tree.num_bytes();
    return sum;
  }
};

SampleTree BuildSampleTree(const SurfaceSamples& samples);

// What BuildSampleTree will take, before it does. Errors: SamplingBytes.
struct SampleTreeEstimate {
  double stored_bytes = 0.0;  // of the tree and the coarser ones
  double peak_bytes = 0.0;    // while they are built, they included, mesh not
};
core::Result<SampleTreeEstimate> EstimateSampleTree(const TriangleMesh& mesh, std::uint32_t num_points);

// Samples a surface, and again with fewer points as long as these are at least kFewestCoarse. Errors: SampleSurface.
constexpr std::uint32_t kFewestCoarse = 8192;
core::Result<SampleTree> BuildSampleTree(const TriangleMesh& mesh, std::uint32_t num_points,
                                         const std::function<void(std::string_view, double)>& progress = {});

}  // namespace vps
