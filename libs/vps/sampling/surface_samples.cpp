#include "vps/sampling/surface_samples.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <numeric>
#include <random>
#include <string>

#include "vps/pointshell/crowd_heap.hpp"
#include "vps/pointshell/pointshell.hpp"
#include "vps/sampling/graded_grid.hpp"
#include "vps/sampling/surface_panels.hpp"

namespace vps {
namespace {

// None of the three is derived: panels whose normal differs by more belong to another face (cosine of 45 degrees); more
// candidates and rounds spread the points more evenly and take time.
constexpr double kSameFace = 0.7071;
constexpr std::uint32_t kCandidatesPerPoint = 4;
constexpr int kRelaxations = 2;

using Progress = std::function<void(std::string_view, double)>;

// Points whose spacing varies, with outward normals.
struct Places {
  std::vector<glm::dvec3> points_m, normals;
  std::vector<double> spacings_m;
};

// Centroids of panels: one in each of `count` equal shares of the running number of points, at a random place of the
// share, so that no lattice shows.
Places ChooseCandidates(const std::vector<SurfacePanel>& panels, std::size_t count) {
  double total = 0.0;
  for (const SurfacePanel& panel : panels) total += panel.area_m2 / (panel.spacing_m * panel.spacing_m);
  Places places;
  std::mt19937_64 random(0x5eed);
  std::size_t at = 0;
  double running = panels[0].area_m2 / (panels[0].spacing_m * panels[0].spacing_m);
  for (std::size_t k = 0; k < count; ++k) {
    const double jitter = static_cast<double>(random() >> 11) * 0x1p-53;
    const double target = (static_cast<double>(k) + jitter) / static_cast<double>(count) * total;
    while (at + 1 < panels.size() && running < target) {
      ++at;
      running += panels[at].area_m2 / (panels[at].spacing_m * panels[at].spacing_m);
    }
    places.points_m.push_back(panels[at].centroid_m);
    places.normals.push_back(panels[at].normal);
    places.spacings_m.push_back(panels[at].spacing_m);
  }
  return places;
}

// Weight that candidate j puts on i: (1 - d / (2 r))^8 for d < 2 r. r is half the distance of neighbours in a hexagonal
// packing of the spacing's area, h^2 = 2 sqrt(3) r^2, with the mean spacing of the two.
Places Thin(const Places& candidates, std::size_t num_points, const Progress& progress) {
  const std::size_t count = candidates.points_m.size();
  const double reach_per_spacing = 2.0 / std::sqrt(2.0 * std::numbers::sqrt3);
  const auto weight = [&](std::size_t i, std::size_t j) {
    if (glm::dot(candidates.normals[i], candidates.normals[j]) < -0.5) return 0.0;
    const glm::dvec3 r = candidates.points_m[i] - candidates.points_m[j];
    const double reach = 0.5 * reach_per_spacing * (candidates.spacings_m[i] + candidates.spacings_m[j]);
    const double squared = glm::dot(r, r);
    if (squared >= reach * reach) return 0.0;
    double w = 1.0 - std::sqrt(squared) / reach;
    w *= w;
    w *= w;
    return w * w;
  };
  const GradedGrid grid(candidates.points_m, candidates.spacings_m);
  std::vector<double> weights(count, 0.0);
  for (std::uint32_t i = 0; i < count; ++i) {
    grid.ForNear(candidates.points_m[i], candidates.spacings_m[i], reach_per_spacing, [&](std::uint32_t j) {
      if (j != i) weights[i] += weight(i, j);
    });
    if (progress && i % 16384 == 0) progress("points: crowding", 0.5 * i / static_cast<double>(count));
  }
  CrowdHeap heap(std::move(weights));
  const std::size_t num_removed = count - num_points;
  for (std::size_t k = 0; k < num_removed; ++k) {
    const std::uint32_t i = heap.PopHeaviest();
    grid.ForNear(candidates.points_m[i], candidates.spacings_m[i], reach_per_spacing, [&](std::uint32_t j) {
      if (!heap.contains(j)) return;
      const double w = weight(i, j);
      if (w > 0.0) heap.Lower(j, w);
    });
    if (progress && k % 16384 == 0) {
      progress("points: thinning", 0.5 + 0.5 * static_cast<double>(k) / static_cast<double>(num_removed));
    }
  }
  Places kept;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (!heap.contains(i)) continue;
    kept.points_m.push_back(candidates.points_m[i]);
    kept.normals.push_back(candidates.normals[i]);
    kept.spacings_m.push_back(candidates.spacings_m[i]);
  }
  return kept;
}

constexpr std::uint32_t kNobody = 0xffffffffU;

// For each panel the point it belongs to: the nearest whose normal is within 45 degrees of its own; where there is none
// near, the nearest of all.
std::uint32_t OwnerOf(const SurfacePanel& panel, const Places& places, const GradedGrid& grid) {
  std::uint32_t nearest = kNobody;
  std::uint32_t nearest_of_any = kNobody;
  double least = 1e300;
  double least_of_any = 1e300;
  for (const double factor : {1.4, 4.0}) {
    grid.ForNear(panel.centroid_m, panel.spacing_m, factor, [&](std::uint32_t i) {
      const glm::dvec3 r = places.points_m[i] - panel.centroid_m;
      const double squared = glm::dot(r, r);
      if (squared < least_of_any || (squared == least_of_any && i < nearest_of_any)) {
        least_of_any = squared;
        nearest_of_any = i;
      }
      if (squared > least || (squared == least && i > nearest)) return;
      if (glm::dot(places.normals[i], panel.normal) < kSameFace) return;
      least = squared;
      nearest = i;
    });
    if (least <= std::pow(0.5 * factor * panel.spacing_m, 2)) break;
  }
  return nearest != kNobody ? nearest : nearest_of_any;
}
std::vector<std::uint32_t> Assign(const std::vector<SurfacePanel>& panels, const Places& places,
                                  core::ParallelFor* workers) {
  constexpr std::size_t kPanelsOfBlock = 4096;  // free: as kTrianglesOfBlock
  const GradedGrid grid(places.points_m, places.spacings_m);
  std::vector<std::uint32_t> owners(panels.size());
  core::ForEach(workers, (panels.size() + kPanelsOfBlock - 1) / kPanelsOfBlock, [&](std::size_t block) {
    const std::size_t end = std::min((block + 1) * kPanelsOfBlock, panels.size());
    for (std::size_t i = block * kPanelsOfBlock; i < end; ++i) owners[i] = OwnerOf(panels[i], places, grid);
  });
  return owners;
}

struct Cell {
  double area_m2 = 0.0;
  glm::dvec3 place{0.0};   // times area
  glm::dvec3 normal{0.0};  // times area
};

// The refinement of each point's patch.
std::vector<FineBlock> Refine(const std::vector<SurfacePanel>& panels, const std::vector<std::uint32_t>& owners,
                              const SurfaceSamples& samples, core::ParallelFor* workers) {
  // Panels sorted by their owner.
  std::vector<std::uint32_t> begin(samples.points_m.size() + 1, 0);
  for (const std::uint32_t owner : owners) {
    if (owner != kNobody) ++begin[owner + 1];
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  std::vector<std::uint32_t> sorted(begin.back());
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  for (std::uint32_t i = 0; i < owners.size(); ++i) {
    if (owners[i] != kNobody) sorted[next[owners[i]]++] = i;
  }
  std::vector<FineBlock> fine(samples.points_m.size());
  core::ForEach(workers, fine.size(), [&](std::size_t k) {
    const std::span<std::uint32_t> cell(sorted.data() + begin[k], sorted.data() + begin[k + 1]);
    fine[k] = MakeFineBlock(panels, cell, samples.points_m[k], samples.inward_normals[k]);
  });
  return fine;
}

}  // namespace

namespace {

double PanelSize(std::uint32_t num_points) {
  return num_points <= kMaxFinePoints ? kFinePanelSize : kPanelSize;
}

core::Result<double> AreaToSample_m2(const TriangleMesh& mesh, std::uint32_t num_points) {
  if (num_points == 0 || num_points > kMaxPoints) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "the number of points must be between 1 and " + std::to_string(kMaxPoints));
  }
  const double area_m2 = SurfaceArea_m2(mesh);
  if (!(area_m2 > 0.0)) return core::Fail(core::ErrorCode::kInvalidInput, "the mesh has no area to sample");
  return area_m2;
}

// Of what is needed for so many panels and points.
core::Result<double> CheckedBytes(std::size_t num_panels, std::uint32_t num_points) {
  // A panel, its owner and its place in the owners' order; a point's candidates with their heap and grid, and what is
  // kept of it.
  constexpr double kBytesPerPanel = sizeof(SurfacePanel) + 2 * sizeof(std::uint32_t);
  constexpr double kBytesPerPoint = 600.0;
  const double bytes = kBytesPerPanel * static_cast<double>(num_panels) + kBytesPerPoint * num_points;
  if (bytes <= kMostSamplingBytes) return bytes;
  char text[200];
  std::snprintf(
      text, sizeof text,
      "%u points take about %.3g MB of memory while they are spread, more than the %.3g MB allowed: take fewer",
      num_points, 1e-6 * bytes, 1e-6 * kMostSamplingBytes);
  return core::Fail(core::ErrorCode::kResource, text);
}

}  // namespace

core::Result<double> SamplingBytes(const TriangleMesh& mesh, std::uint32_t num_points) {
  const auto area_m2 = AreaToSample_m2(mesh, num_points);
  if (!area_m2) return tl::unexpected(area_m2.error());
  const SampleSpacing spacing(mesh, *area_m2, num_points);
  return CheckedBytes(CountPanels(mesh, spacing, PanelSize(num_points)).back(), num_points);
}

core::Result<SurfaceSamples> SampleSurface(const TriangleMesh& mesh, std::uint32_t num_points, const Progress& progress,
                                           core::ParallelFor* workers) {
  const auto checked_area_m2 = AreaToSample_m2(mesh, num_points);
  if (!checked_area_m2) return tl::unexpected(checked_area_m2.error());
  const double area_m2 = *checked_area_m2;
  if (progress) progress("points: panels", 0.0);
  const SampleSpacing spacing(mesh, area_m2, num_points);
  const std::vector<std::size_t> begins = CountPanels(mesh, spacing, PanelSize(num_points), workers);
  if (const auto bytes = CheckedBytes(begins.back(), num_points); !bytes) return tl::unexpected(bytes.error());
  const std::vector<SurfacePanel> panels = MakePanels(mesh, spacing, PanelSize(num_points), begins, workers);
  Places places = Thin(ChooseCandidates(panels, std::size_t{kCandidatesPerPoint} * num_points), num_points, progress);

  std::vector<std::uint32_t> owners;
  std::vector<Cell> cells;
  for (int round = 0; round < kRelaxations; ++round) {
    if (progress) progress("points: areas", static_cast<double>(round) / kRelaxations);
    owners = Assign(panels, places, workers);
    cells.assign(num_points, {});
    for (std::size_t i = 0; i < panels.size(); ++i) {
      if (owners[i] == kNobody) continue;
      Cell& cell = cells[owners[i]];
      cell.area_m2 += panels[i].area_m2;
      cell.place += panels[i].area_m2 * panels[i].centroid_m;
      cell.normal += panels[i].area_m2 * panels[i].normal;
    }
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (cells[i].area_m2 == 0.0) continue;
      places.points_m[i] = cells[i].place / cells[i].area_m2;
      if (glm::length(cells[i].normal) > 0.0) places.normals[i] = glm::normalize(cells[i].normal);
    }
  }
  SurfaceSamples samples;
  double given_m2 = 0.0;
  for (const Cell& cell : cells) given_m2 += cell.area_m2;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    samples.points_m.push_back(places.points_m[i]);
    samples.inward_normals.push_back(cells[i].area_m2 > 0.0 ? -cells[i].normal / cells[i].area_m2 : -places.normals[i]);
    samples.areas_m2.push_back(cells[i].area_m2 * (area_m2 / given_m2));
  }
  for (std::size_t i = 0; i < panels.size(); ++i) {
    if (owners[i] == kNobody) continue;
    samples.reach_m =
        std::max(samples.reach_m, glm::length(panels[i].centroid_m - samples.points_m[owners[i]]) + panels[i].radius_m);
  }
  if (num_points <= kMaxFinePoints) samples.fine = Refine(panels, owners, samples, workers);
  return samples;
}

}  // namespace vps
