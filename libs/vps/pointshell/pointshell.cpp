#include "vps/pointshell/pointshell.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "vps/pointshell/crowd_heap.hpp"
#include "vps/pointshell/point_grid.hpp"

namespace vps {
namespace {

// Not derived: more candidates spread the points more evenly (test Pointshell.KeepsItsPointsApart) and take time in
// proportion.
constexpr std::uint32_t kCandidatesPerPoint = 4;

// Candidate k lies at the share (k + 1/2) / count of the total area, in triangle order: every triangle gets its share
// to within one. Inside the triangle the place is random: an even lattice is crowded differently on triangles of
// different shape, and thinning would turn that into different densities.
Pointshell SampleByArea(const TriangleMesh& mesh, std::size_t count, double* area_m2) {
  std::vector<double> cumulative;
  double area = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = mesh.corners(i);
    area += 0.5 * glm::length(glm::cross(b - a, c - a));
    cumulative.push_back(area);
  }
  *area_m2 = area;
  Pointshell shell;
  if (!(area > 0.0)) return shell;
  std::size_t triangle = 0;
  std::mt19937_64 random(0x5eed);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  for (std::size_t k = 0; k < count; ++k) {
    const double target = (static_cast<double>(k) + 0.5) / static_cast<double>(count) * area;
    while (triangle + 1 < cumulative.size() && cumulative[triangle] < target) ++triangle;
    const auto [a, b, c] = mesh.corners(triangle);
    const double u = uniform();
    const double v = uniform();
    const double s = u + v > 1.0 ? 1.0 - u : u;  // the far half of the square folds onto the triangle
    const double t = u + v > 1.0 ? 1.0 - v : v;
    shell.points_m.push_back(a + s * (b - a) + t * (c - a));
    shell.inward_normals.push_back(-glm::normalize(glm::cross(b - a, c - a)));
  }
  return shell;
}

}  // namespace

core::Result<Pointshell> BuildPointshell(const TriangleMesh& mesh, std::uint32_t num_points,
                                         const std::function<void(std::string_view, double)>& progress,
                                         core::ParallelFor* workers) {
  if (num_points == 0 || num_points > kMaxPoints) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "the number of points must be between 1 and " + std::to_string(kMaxPoints));
  }
  double area_m2 = 0.0;
  const Pointshell candidates = SampleByArea(mesh, std::size_t{kCandidatesPerPoint} * num_points, &area_m2);
  if (candidates.points_m.empty()) return core::Fail(core::ErrorCode::kInvalidInput, "the mesh has no area to sample");

  // Weight that candidate j puts on i: (1 - d / (2 r))^8 for d < 2 r, with r the largest Poisson radius that fits
  // num_points disks of hexagonal packing on the area: area = 2 sqrt(3) r^2 n.
  const double reach = 2.0 * std::sqrt(area_m2 / (2.0 * std::numbers::sqrt3 * num_points));
  const auto weight = [&](std::size_t i, std::size_t j) {
    if (glm::dot(candidates.inward_normals[i], candidates.inward_normals[j]) < -0.5) return 0.0;
    const glm::dvec3 r = candidates.points_m[i] - candidates.points_m[j];
    const double squared = glm::dot(r, r);
    if (squared >= reach * reach) return 0.0;
    double w = 1.0 - std::sqrt(squared) / reach;
    w *= w;
    w *= w;
    return w * w;
  };
  const PointGrid grid(candidates.points_m, reach);
  std::vector<double> weights(candidates.points_m.size(), 0.0);
  constexpr std::size_t kOfBlock = 4096;  // free: enough blocks for all workers
  if (progress) progress("points: crowding", 0.0);
  core::ForEach(workers, (weights.size() + kOfBlock - 1) / kOfBlock, [&](std::size_t block) {
    const std::size_t end = std::min((block + 1) * kOfBlock, weights.size());
    for (std::size_t i = block * kOfBlock; i < end; ++i) {
      grid.ForNear(candidates.points_m[i], reach, [&](std::uint32_t j) {
        if (j != i) weights[i] += weight(i, j);
      });
    }
  });
  CrowdHeap heap(std::move(weights));
  const std::size_t num_removed = candidates.points_m.size() - num_points;
  for (std::size_t k = 0; k < num_removed; ++k) {
    const std::uint32_t i = heap.PopHeaviest();
    grid.ForNear(candidates.points_m[i], reach, [&](std::uint32_t j) {
      if (!heap.contains(j)) return;
      const double w = weight(i, j);
      if (w > 0.0) heap.Lower(j, w);
    });
    if (progress && k % 16384 == 0) {
      progress("points: thinning", 0.5 + 0.5 * static_cast<double>(k) / static_cast<double>(num_removed));
    }
  }
  Pointshell shell;
  for (std::uint32_t i = 0; i < candidates.points_m.size(); ++i) {
    if (!heap.contains(i)) continue;
    shell.points_m.push_back(candidates.points_m[i]);
    shell.inward_normals.push_back(candidates.inward_normals[i]);
  }
  return shell;
}

}  // namespace vps
