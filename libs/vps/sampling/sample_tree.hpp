#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <string_view>
#include <vector>

#include "core/result.hpp"
#include "vps/mesh/triangle_mesh.hpp"
#include "vps/sampling/fine_block.hpp"
#include "vps/sampling/sphere_tree.hpp"
#include "vps/sampling/surface_pieces.hpp"
#include "vps/sampling/surface_samples.hpp"

namespace vps {

// Surface samples in the order of a tree: point block b holds points 16 b ... 16 b + 15, sphere j of level 0 holds
// point block j. Points that share a block are neighbours. Blocks are filled up with points of no area, far away. Mesh
// frame, metres.
struct SampleTree : SphereTree {
  std::uint32_t num_points = 0;
  double area_m2 = 0.0;
  glm::dvec3 centre_m{0.0};  // sphere around all
  double radius_m = 0.0;
  std::vector<PointBlock> points;
  std::vector<FineBlock> fine;      // refinement of each point, in their order; empty: none
  SurfacePieces pieces;             // the surface itself, where there are finer points and at most kMostPieces pieces
  double refined_m = 0.0;           // samples farther from the other body are not refined: 1.2 radii of a typical patch
  double reach_m = 0.0;             // largest radius of a patch about its point
  std::vector<SampleTree> coarser;  // the same surface in a quarter of the points, in a sixteenth, ...: LevelWalk

  [[nodiscard]] std::size_t num_bytes() const {
    std::size_t sum =
        points.size() * sizeof(PointBlock) + spheres.size() * sizeof(SphereBlock) + fine.size() * sizeof(FineBlock);
    sum += pieces.num_bytes();
    for (const SampleTree& tree : coarser) sum += tree.num_bytes();
    return sum;
  }
};

SampleTree BuildSampleTree(const SurfaceSamples& samples);

// Upper estimate of BuildSampleTree's memory. Errors: SamplingBytes.
struct SampleTreeEstimate {
  double stored_bytes = 0.0;  // of the tree and the coarser ones
  double peak_bytes = 0.0;    // while they are built, they included, mesh not
};
core::Result<SampleTreeEstimate> EstimateSampleTree(const TriangleMesh& mesh, std::uint32_t num_points);

// Samples a surface, and again with a quarter of the points, ..., down to kFewestCoarse (decision 11: with fewer the
// error of a broad contact grows). Errors: SampleSurface.
constexpr std::uint32_t kFewestCoarse = 8192;
core::Result<SampleTree> BuildSampleTree(const TriangleMesh& mesh, std::uint32_t num_points,
                                         const std::function<void(std::string_view, double)>& progress = {},
                                         core::ParallelFor* workers = nullptr);

}  // namespace vps
