#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "core/result.hpp"
#include "vps/mesh/triangle_mesh.hpp"
#include "vps/sampling/point_block.hpp"
#include "vps/sampling/sphere_tree.hpp"
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
  double usual_m = 0.0;  // a typical place of the surface is no farther from its sample
  double reach_m = 0.0;  // largest radius of a patch about its point

  [[nodiscard]] std::size_t num_bytes() const {
    return points.size() * sizeof(PointBlock) + spheres.size() * sizeof(SphereBlock);
  }
};

SampleTree BuildSampleTree(const SurfaceSamples& samples);

// Upper estimate of BuildSampleTree's memory. Errors: those of PlanSampling.
struct SampleTreeEstimate {
  double stored_bytes = 0.0;  // of the tree
  double peak_bytes = 0.0;    // while it is built, it included, mesh not
};
core::Result<SampleTreeEstimate> EstimateSampleTree(const TriangleMesh& mesh, std::uint32_t num_points);

}  // namespace vps
