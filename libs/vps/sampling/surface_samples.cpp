#include "vps/sampling/surface_samples.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <numeric>
#include <random>
#include <span>
#include <string>
#include <utility>

#include "vps/pointshell/crowd_heap.hpp"
#include "vps/pointshell/pointshell.hpp"
#include "vps/sampling/graded_grid.hpp"
#include "vps/sampling/panel_owners.hpp"
#include "vps/sampling/surface_panels.hpp"

namespace vps {
namespace {

// Neither is derived: more candidates and rounds spread the points more evenly and take time.
constexpr std::uint32_t kCandidatesPerPoint = 4;
constexpr int kRelaxations = 2;
// Panels that are made while they are counted, 300 MB of them; more are made after it is known that they fit. Not
// derived: enough for the points that scenarios have.
constexpr std::size_t kMostKeptPanels = 1U << 22U;

using Progress = std::function<void(std::string_view, double)>;

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
const double kReachPerSpacing = 2.0 / std::sqrt(2.0 * std::numbers::sqrt3);
double CrowdWeight(const Places& candidates, std::size_t i, std::size_t j) {
  if (glm::dot(candidates.normals[i], candidates.normals[j]) < -0.5) return 0.0;
  const glm::dvec3 r = candidates.points_m[i] - candidates.points_m[j];
  const double reach = 0.5 * kReachPerSpacing * (candidates.spacings_m[i] + candidates.spacings_m[j]);
  const double squared = glm::dot(r, r);
  if (squared >= reach * reach) return 0.0;
  double w = 1.0 - std::sqrt(squared) / reach;
  w *= w;
  w *= w;
  return w * w;
}

// Whom each candidate crowds, and how much it is crowded itself.
class Crowd {
 public:
  Crowd(const Places& candidates, const Progress& progress, core::ParallelFor* workers)
      : weights(candidates.points_m.size(), 0.0),
        ends_(weights.size()),
        blocks_((weights.size() + kOfBlock - 1) / kOfBlock) {
    const GradedGrid grid(candidates.points_m, candidates.spacings_m);
    for (std::size_t first = 0; first < blocks_.size(); first += kBlocksPerReport) {
      if (progress)
        progress("points: crowding", 0.5 * static_cast<double>(first) / static_cast<double>(blocks_.size()));
      core::ForEach(workers, std::min(kBlocksPerReport, blocks_.size() - first),
                    [&](std::size_t k) { FindNeighbours(candidates, grid, first + k); });
    }
  }

  [[nodiscard]] std::span<const std::uint32_t> neighbours(std::size_t i) const {
    const std::uint32_t begin = i % kOfBlock == 0 ? 0 : ends_[i - 1];
    return std::span(blocks_[i / kOfBlock]).subspan(begin, ends_[i] - begin);
  }

  std::vector<double> weights;

 private:
  static constexpr std::size_t kOfBlock = 1024;  // free: as kTrianglesOfBlock
  static constexpr std::size_t kBlocksPerReport = 64;

  void FindNeighbours(const Places& candidates, const GradedGrid& grid, std::size_t b) {
    std::vector<std::uint32_t>& neighbours = blocks_[b];
    const std::size_t end = std::min((b + 1) * kOfBlock, weights.size());
    for (std::size_t i = b * kOfBlock; i < end; ++i) {
      grid.ForNear(candidates.points_m[i], candidates.spacings_m[i], kReachPerSpacing, [&](std::uint32_t j) {
        const double weight = j == i ? 0.0 : CrowdWeight(candidates, i, j);
        if (weight == 0.0) return;
        weights[i] += weight;
        neighbours.push_back(j);
      });
      ends_[i] = static_cast<std::uint32_t>(neighbours.size());
    }
  }

  std::vector<std::uint32_t> ends_;  // of each candidate's neighbours in its block's
  std::vector<std::vector<std::uint32_t>> blocks_;
};

Places Thin(const Places& candidates, std::size_t num_points, const Progress& progress, core::ParallelFor* workers) {
  const std::size_t count = candidates.points_m.size();
  Crowd crowd(candidates, progress, workers);
  CrowdHeap heap(std::move(crowd.weights));
  const std::size_t num_removed = count - num_points;
  for (std::size_t k = 0; k < num_removed; ++k) {
    const std::uint32_t i = heap.PopHeaviest();
    for (const std::uint32_t j : crowd.neighbours(i)) {
      if (heap.contains(j)) heap.Lower(j, CrowdWeight(candidates, i, j));
    }
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

struct Cell {
  double area_m2 = 0.0;
  glm::dvec3 place{0.0};   // times area
  glm::dvec3 normal{0.0};  // times area
};

// The panels of each cell are added in their order, whoever does it: a task adds those of its share of the cells.
std::vector<Cell> SumCells(const std::vector<SurfacePanel>& panels, const std::vector<std::uint32_t>& owners,
                           std::uint32_t num_points, core::ParallelFor* workers) {
  constexpr std::size_t kShares = 8;  // free: enough for some workers; each looks at all owners
  std::vector<Cell> cells(num_points);
  core::ForEach(workers, kShares, [&](std::size_t share) {
    const std::size_t begin = share * num_points / kShares;
    const std::size_t end = (share + 1) * num_points / kShares;
    for (std::size_t i = 0; i < panels.size(); ++i) {
      if (owners[i] < begin || owners[i] >= end) continue;  // that of nobody's panels is no cell
      Cell& cell = cells[owners[i]];
      cell.area_m2 += panels[i].area_m2;
      cell.place += panels[i].area_m2 * panels[i].centroid_m;
      cell.normal += panels[i].area_m2 * panels[i].normal;
    }
  });
  return cells;
}

// Largest radius of a cell about its point.
double FindReach_m(const std::vector<SurfacePanel>& panels, const std::vector<std::uint32_t>& owners,
                   const std::vector<glm::dvec3>& points_m, core::ParallelFor* workers) {
  constexpr std::size_t kPanelsOfBlock = 1U << 16U;  // free
  std::vector<double> reaches_m((panels.size() + kPanelsOfBlock - 1) / kPanelsOfBlock, 0.0);
  core::ForEach(workers, reaches_m.size(), [&](std::size_t block) {
    const std::size_t end = std::min((block + 1) * kPanelsOfBlock, panels.size());
    for (std::size_t i = block * kPanelsOfBlock; i < end; ++i) {
      if (owners[i] == kNobody) continue;
      const double here_m = glm::length(panels[i].centroid_m - points_m[owners[i]]) + panels[i].radius_m;
      reaches_m[block] = std::max(reaches_m[block], here_m);
    }
  });
  return *std::max_element(reaches_m.begin(), reaches_m.end());
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
  // A panel, its owner and its place in the owners' order; before there are points, the panels kept of counting, and
  // then a point's candidates with their heap, grid and neighbours (about fifteen each), and what is kept of it.
  constexpr double kBytesPerPanel = sizeof(SurfacePanel) + 2 * sizeof(std::uint32_t);
  constexpr double kBytesPerPoint = 1000.0;
  const double kept = sizeof(SurfacePanel) * static_cast<double>(std::min(num_panels, kMostKeptPanels));
  const double bytes = kBytesPerPanel * static_cast<double>(num_panels) + std::max(kept, kBytesPerPoint * num_points);
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
  return CheckedBytes(CountPanels(mesh, spacing, kPanelSize).begins.back(), num_points);
}

core::Result<SurfaceSamples> SampleSurface(const TriangleMesh& mesh, std::uint32_t num_points, const Progress& progress,
                                           core::ParallelFor* workers) {
  const auto checked_area_m2 = AreaToSample_m2(mesh, num_points);
  if (!checked_area_m2) return tl::unexpected(checked_area_m2.error());
  const double area_m2 = *checked_area_m2;
  if (progress) progress("points: panels", 0.0);
  const SampleSpacing spacing(mesh, area_m2, num_points);
  PanelCount count = CountPanels(mesh, spacing, kPanelSize, kMostKeptPanels, workers);
  if (const auto bytes = CheckedBytes(count.begins.back(), num_points); !bytes) return tl::unexpected(bytes.error());
  const std::vector<SurfacePanel> panels = MakePanels(mesh, spacing, kPanelSize, std::move(count), workers);
  Places places =
      Thin(ChooseCandidates(panels, std::size_t{kCandidatesPerPoint} * num_points), num_points, progress, workers);

  std::vector<std::uint32_t> owners;
  std::vector<Cell> cells;
  for (int round = 0; round < kRelaxations; ++round) {
    if (progress) progress("points: areas", static_cast<double>(round) / kRelaxations);
    owners = FindOwners(panels, places, workers);
    cells = SumCells(panels, owners, num_points, workers);
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
  samples.reach_m = FindReach_m(panels, owners, samples.points_m, workers);
  return samples;
}

}  // namespace vps
