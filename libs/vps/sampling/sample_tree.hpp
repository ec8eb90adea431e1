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
// point block j. Points that share a block are neighbours. Places without a point are filled with points of no area,
// far away.
struct SampleTree : SphereTree {
  std::uint32_t num_points = 0;
  double area_m2 = 0.0;
  glm::dvec3 centre_m{0.0};  // sphere around all
  double radius_m = 0.0;
  std::vector<PointBlock> points;
  std::vector<FineBlock> fine;  // of each point, in their order; empty: the points are as fine as it gets
  SurfacePieces pieces;         // the surface itself, where there are finer points and it has not too many triangles
  double refined_m = 0.0;       // a sample farther than this from the other body is not taken finer; of a typical patch
  double reach_m = 0.0;         // no place of the surface is farther from the point that stands for it
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
