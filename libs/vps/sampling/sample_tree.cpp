#include "vps/sampling/sample_tree.hpp"

#include <cmath>

#include "vps/tree/build_tree.hpp"

namespace vps {
namespace {

// The mean direction of a block's points, unit or zero.
glm::vec3 MeanNormal(const PointBlock& points) {
  glm::vec3 sum(0.0f);
  for (std::size_t k = 0; k < kBlock; ++k) {
    sum += points.area_m2[k] * glm::vec3(points.nx[k], points.ny[k], points.nz[k]);
  }
  const float length = glm::length(sum);
  return length > 0.0f ? sum / length : glm::vec3(0.0f);
}

// Radius of a typical patch over the root of its area, with some room: a regular hexagon has 0.62 (of its corners),
// patches have longer corners. Not derived further.
constexpr double kPatchReach = 0.84;

}  // namespace

SampleTree BuildSampleTree(const SurfaceSamples& samples) {
  const std::size_t n = samples.points_m.size();
  SampleTree tree;
  tree.num_points = static_cast<std::uint32_t>(n);
  if (n == 0) return tree;
  const std::vector<std::uint32_t> order = OrderInRuns(samples.points_m);
  tree.reach_m = samples.reach_m;
  const std::size_t num_blocks = (n + kBlock - 1) / kBlock;
  tree.points.resize(num_blocks);
  std::vector<glm::vec3> places(n);
  for (std::size_t i = 0; i < num_blocks * kBlock; ++i) {
    PointBlock& block = tree.points[i / kBlock];
    const std::size_t lane = i % kBlock;
    if (i >= n) {
      block.x[lane] = SampleTree::kFarAway_m;
      block.nx[lane] = 1.0f;
      continue;
    }
    const glm::vec3 p(samples.points_m[order[i]]);
    const glm::vec3 normal(samples.inward_normals[order[i]]);
    places[i] = p;
    block.x[lane] = p.x;
    block.y[lane] = p.y;
    block.z[lane] = p.z;
    block.nx[lane] = normal.x;
    block.ny[lane] = normal.y;
    block.nz[lane] = normal.z;
    block.area_m2[lane] = static_cast<float>(samples.areas_m2[order[i]]);
    tree.area_m2 += samples.areas_m2[order[i]];
    tree.usual_m += kPatchReach * std::pow(samples.areas_m2[order[i]], 1.5);
  }
  tree.usual_m /= tree.area_m2;

  std::vector<glm::vec3> normals;
  for (const PointBlock& block : tree.points) normals.push_back(MeanNormal(block));
  static_cast<SphereTree&>(tree) = BuildSphereTree(places, normals);
  const Sphere all = SmallestSphere(places);
  tree.centre_m = all.centre;
  tree.radius_m = all.radius * (1.0 + 1e-6) + 4e-7 * glm::length(all.centre);
  return tree;
}

core::Result<SampleTreeEstimate> EstimateSampleTree(const TriangleMesh& mesh, std::uint32_t num_points) {
  const auto plan = PlanSampling(mesh, num_points);
  if (!plan) return tl::unexpected(plan.error());
  // Each sphere block holds sixteen blocks of points, and the levels above a fifteenth of that.
  constexpr double kBlockBytes = sizeof(PointBlock) + sizeof(SphereBlock) * (1.0 / kBlock) * (1.0 + 1.0 / 15.0);
  const double num_blocks = std::ceil(static_cast<double>(num_points) / kBlock);
  SampleTreeEstimate estimate;
  estimate.stored_bytes = kBlockBytes * num_blocks + sizeof(SphereBlock) * SampleTree::kMaxLevels;
  estimate.peak_bytes = plan->bytes + estimate.stored_bytes;
  return estimate;
}

}  // namespace vps
