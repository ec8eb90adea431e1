#include "vps/sampling/sample_tree.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "vps/tree/build_tree.hpp"

namespace vps {
namespace {

// Sorts order[begin, end) so that aligned runs of 16, 256, 4096 ... points are compact: halves along the longest side
// at multiples of the largest run that is smaller than the range.
void SortIntoRuns(const std::vector<glm::dvec3>& points, std::size_t begin, std::size_t end,
                  std::vector<std::uint32_t>* order) {
  const std::size_t count = end - begin;
  if (count <= kBlock) return;
  std::size_t run = kBlock;
  while (run * kBlock < count) run *= kBlock;
  glm::dvec3 lower(1e300);
  glm::dvec3 upper(-1e300);
  for (std::size_t i = begin; i < end; ++i) {
    lower = glm::min(lower, points[(*order)[i]]);
    upper = glm::max(upper, points[(*order)[i]]);
  }
  const glm::dvec3 extent = upper - lower;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : (extent.y >= extent.z ? 1 : 2);
  const std::size_t num_runs = (count + run - 1) / run;
  const std::size_t middle = begin + (num_runs / 2) * run;
  std::nth_element(order->begin() + static_cast<std::ptrdiff_t>(begin),
                   order->begin() + static_cast<std::ptrdiff_t>(middle),
                   order->begin() + static_cast<std::ptrdiff_t>(end), [&](std::uint32_t a, std::uint32_t b) {
                     return points[a][axis] != points[b][axis] ? points[a][axis] < points[b][axis] : a < b;
                   });
  SortIntoRuns(points, begin, middle, order);
  SortIntoRuns(points, middle, end, order);
}

// The slab of a point block's points, around the centre of its sphere and across their mean normal.
void FindSlab(const PointBlock& points, std::size_t count, std::size_t lane, SphereBlock* block) {
  glm::vec3 sum(0.0f);
  for (std::size_t k = 0; k < count; ++k) {
    sum += points.area_m2[k] * glm::vec3(points.nx[k], points.ny[k], points.nz[k]);
  }
  const float length = glm::length(sum);
  if (!(length > 0.0f)) return;
  const glm::vec3 n = sum / length;
  const glm::vec3 centre(block->x[lane], block->y[lane], block->z[lane]);
  float h = 0.0f;
  for (std::size_t k = 0; k < count; ++k) {
    h = std::max(h, std::abs(glm::dot(glm::vec3(points.x[k], points.y[k], points.z[k]) - centre, n)));
  }
  block->nx[lane] = n.x;
  block->ny[lane] = n.y;
  block->nz[lane] = n.z;
  block->h[lane] = h * (1.0f + 1e-6f) + 4e-7f * glm::length(centre);
}

SphereBlock FarBlock() {
  SphereBlock block{};
  std::fill(std::begin(block.x), std::end(block.x), SampleTree::kFarAway_m);
  return block;
}

}  // namespace

SampleTree BuildSampleTree(const SurfaceSamples& samples) {
  const std::size_t n = samples.points_m.size();
  SampleTree tree;
  tree.num_points = static_cast<std::uint32_t>(n);
  if (n == 0) return tree;
  std::vector<std::uint32_t> order(n);
  std::iota(order.begin(), order.end(), 0U);
  SortIntoRuns(samples.points_m, 0, n, &order);
  tree.reach_m = samples.reach_m;
  double sum = 0.0;
  double total_m2 = 0.0;
  for (const double area_m2 : samples.areas_m2) {
    sum += area_m2 * static_cast<double>(kPatchReach) * std::sqrt(area_m2);
    total_m2 += area_m2;
  }
  tree.refined_m = 1.2 * sum / total_m2;
  tree.fine.reserve(samples.fine.size());
  for (std::size_t i = 0; i < samples.fine.size(); ++i) tree.fine.push_back(samples.fine[order[i]]);

  const std::size_t num_blocks = (n + kBlock - 1) / kBlock;
  tree.points.resize(num_blocks);
  std::vector<float> x(n), y(n), z(n);
  for (std::size_t i = 0; i < num_blocks * kBlock; ++i) {
    PointBlock& block = tree.points[i / kBlock];
    const std::size_t lane = i % kBlock;
    if (i >= n) {
      block.x[lane] = SampleTree::kFarAway_m;
      block.y[lane] = block.z[lane] = 0.0f;
      block.nx[lane] = 1.0f;
      block.ny[lane] = block.nz[lane] = block.area_m2[lane] = 0.0f;
      continue;
    }
    const glm::vec3 p(samples.points_m[order[i]]);
    const glm::vec3 normal(samples.inward_normals[order[i]]);
    x[i] = block.x[lane] = p.x;
    y[i] = block.y[lane] = p.y;
    z[i] = block.z[lane] = p.z;
    block.nx[lane] = normal.x;
    block.ny[lane] = normal.y;
    block.nz[lane] = normal.z;
    block.area_m2[lane] = static_cast<float>(samples.areas_m2[order[i]]);
    tree.area_m2 += samples.areas_m2[order[i]];
  }

  std::size_t run = kBlock;              // points under one sphere of this level
  std::size_t num_spheres = num_blocks;  // of this level
  while (true) {
    tree.level_begin[tree.num_levels++] = static_cast<std::uint32_t>(tree.spheres.size());
    for (std::size_t j = 0; j < num_spheres; ++j) {
      if (j % kBlock == 0) tree.spheres.push_back(FarBlock());
      const std::size_t begin = j * run;
      const std::size_t count = std::min(run, n - begin);
      const Sphere sphere = SmallestSphere(&x[begin], &y[begin], &z[begin], count);
      SphereBlock& block = tree.spheres.back();
      const std::size_t lane = j % kBlock;
      const glm::vec3 centre(sphere.centre);
      block.x[lane] = centre.x;
      block.y[lane] = centre.y;
      block.z[lane] = centre.z;
      // Of the rounded centre; the pad is some rounding errors of a float of this size.
      float radius = 0.0f;
      for (std::size_t i = begin; i < begin + count; ++i) {
        radius = std::max(radius, glm::length(glm::vec3(x[i], y[i], z[i]) - centre));
      }
      block.r[lane] = radius * (1.0f + 1e-6f) + 4e-7f * glm::length(centre);
      if (tree.num_levels == 1) FindSlab(tree.points[j], count, lane, &block);
    }
    if (num_spheres <= kBlock) break;
    num_spheres = (num_spheres + kBlock - 1) / kBlock;
    run *= kBlock;
  }
  const Sphere all = SmallestSphere(x.data(), y.data(), z.data(), n);
  tree.centre_m = all.centre;
  tree.radius_m = all.radius * (1.0 + 1e-6) + 4e-7 * glm::length(all.centre);
  return tree;
}

core::Result<SampleTreeEstimate> EstimateSampleTree(const TriangleMesh& mesh, std::uint32_t num_points) {
  const auto sampling_bytes = SamplingBytes(mesh, num_points);
  if (!sampling_bytes) return tl::unexpected(sampling_bytes.error());
  // Each sphere block holds sixteen blocks of points, and the levels above a fifteenth of that.
  constexpr double kBlockBytes = sizeof(PointBlock) + sizeof(SphereBlock) * (1.0 / kBlock) * (1.0 + 1.0 / 15.0);
  const auto tree_bytes = [&](std::uint32_t n) {
    return kBlockBytes * std::ceil(static_cast<double>(n) / kBlock) + sizeof(SphereBlock) * SampleTree::kMaxLevels;
  };
  SampleTreeEstimate estimate;
  estimate.stored_bytes = tree_bytes(num_points);
  if (num_points <= kMaxFinePoints) estimate.stored_bytes += double{sizeof(FineBlock)} * num_points;
  for (std::uint32_t n = num_points / 4; n >= kFewestCoarse; n /= 4) estimate.stored_bytes += tree_bytes(n);
  estimate.peak_bytes = *sampling_bytes + estimate.stored_bytes;
  return estimate;
}

core::Result<SampleTree> BuildSampleTree(const TriangleMesh& mesh, std::uint32_t num_points,
                                         const std::function<void(std::string_view, double)>& progress) {
  const auto samples = SampleSurface(mesh, num_points, progress);
  if (!samples) return tl::unexpected(samples.error());
  SampleTree tree = BuildSampleTree(*samples);
  for (std::uint32_t n = num_points / 4; n >= kFewestCoarse; n /= 4) {
    auto fewer = SampleSurface(mesh, n, progress);
    if (!fewer) return tl::unexpected(fewer.error());
    fewer->fine.clear();
    tree.coarser.push_back(BuildSampleTree(*fewer));
  }
  return tree;
}

}  // namespace vps
