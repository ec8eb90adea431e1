#include "vps/sampling/surface_samples.hpp"

#include <cmath>

#include "vps/pointshell/point_grid.hpp"
#include "vps/pointshell/pointshell.hpp"

namespace vps {
namespace {

constexpr double kSameFace = 0.7071;  // cosine of 45 degrees

// Calls visit(place, outward normal, area) for evenly spread places: `share_m2` each, triangles smaller than that one
// place in every so many, chosen by the running area.
template <typename Visit>
void ForProbes(const TriangleMesh& mesh, double share_m2, Visit&& visit) {
  double owed = 0.5;           // places not yet made
  std::uint64_t num_made = 0;  // runs through all triangles, so that small ones do not all get the same place
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b, c] = mesh.corners(t);
    const glm::dvec3 n = glm::cross(b - a, c - a);
    const double length = glm::length(n);
    if (!(length > 0.0)) continue;
    owed += 0.5 * length / share_m2;
    const auto count = static_cast<std::uint64_t>(owed);
    owed -= static_cast<double>(count);
    for (std::uint64_t k = 0; k < count; ++k, ++num_made) {
      // Points of the R2 sequence (Roberts 2018) cover the square evenly; the far half folds onto the triangle.
      double u = std::fmod(0.5 + 0.7548776662466927 * static_cast<double>(num_made), 1.0);
      double v = std::fmod(0.5 + 0.5698402909980532 * static_cast<double>(num_made), 1.0);
      if (u + v > 1.0) {
        u = 1.0 - u;
        v = 1.0 - v;
      }
      visit(a + u * (b - a) + v * (c - a), n / length);
    }
  }
}

}  // namespace

core::Result<SurfaceSamples> SampleSurface(const TriangleMesh& mesh, std::uint32_t num_points,
                                           const std::function<void(std::string_view, double)>& progress) {
  auto shell = BuildPointshell(mesh, num_points, progress);
  if (!shell) return tl::unexpected(shell.error());
  SurfaceSamples samples;
  samples.points_m = std::move(shell->points_m);
  samples.inward_normals = std::move(shell->inward_normals);

  double area_m2 = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto [a, b, c] = mesh.corners(t);
    area_m2 += 0.5 * glm::length(glm::cross(b - a, c - a));
  }
  const double spacing = std::sqrt(area_m2 / num_points);
  const PointGrid grid(samples.points_m, spacing);
  struct Cell {
    std::uint32_t count = 0;
    glm::dvec3 place{0.0};
    glm::dvec3 normal{0.0};
  };
  std::vector<Cell> cells(samples.points_m.size());
  std::uint64_t num_counted = 0;
  std::uint64_t num_done = 0;
  ForProbes(mesh, area_m2 / (double{kProbesPerPoint} * num_points), [&](const glm::dvec3& p, const glm::dvec3& n) {
    if (progress && ++num_done % 65536 == 0) {
      progress("points: areas", static_cast<double>(num_done) / (double{kProbesPerPoint} * num_points));
    }
    std::int64_t nearest = -1;
    double least = 1e300;
    for (const double reach : {1.0 * spacing, 3.0 * spacing}) {
      grid.ForNear(p, reach, [&](std::uint32_t i) {
        if (-glm::dot(samples.inward_normals[i], n) < kSameFace) return;
        const glm::dvec3 r = samples.points_m[i] - p;
        const double squared = glm::dot(r, r);
        if (squared < least || (squared == least && i < nearest)) {
          least = squared;
          nearest = i;
        }
      });
      if (least <= reach * reach) break;
    }
    if (nearest < 0) return;  // a sliver without a point of its own
    Cell& cell = cells[static_cast<std::size_t>(nearest)];
    ++cell.count;
    cell.place += p;
    cell.normal += n;
    ++num_counted;
  });
  // What no point took is spread over all.
  const double share = num_counted > 0 ? area_m2 / static_cast<double>(num_counted) : 0.0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Cell& cell = cells[i];
    samples.areas_m2.push_back(share * cell.count);
    if (cell.count == 0) continue;
    samples.points_m[i] = cell.place / static_cast<double>(cell.count);
    samples.inward_normals[i] = -glm::normalize(cell.normal);
  }
  return samples;
}

}  // namespace vps
