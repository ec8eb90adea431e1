#include "vps/sampling/surface_samples.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "vps/sampling/panel_owners.hpp"
#include "vps/sampling/surface_panels.hpp"

namespace vps {
namespace {

// Twenty panels to a sample, enough for areas and centroids; more rounds spread the points more evenly. Not derived.
constexpr double kPanelSize = 0.6;  // of the spacing
constexpr int kRelaxations = 2;

using Progress = std::function<void(std::string_view, double)>;

struct Cell {
  double area_m2 = 0.0;
  glm::dvec3 place{0.0};   // times area
  glm::dvec3 normal{0.0};  // times area
};

// The panels of each cell are added in their order, whoever does it: a task adds those of its share of the cells.
std::vector<Cell> SumCells(const std::vector<SurfacePanel>& panels, const std::vector<std::uint32_t>& owners,
                           std::size_t num_points, core::ParallelFor* workers) {
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

}  // namespace

core::Result<SamplingPlan> PlanSampling(const TriangleMesh& mesh, std::uint32_t num_points,
                                        core::ParallelFor* workers) {
  if (num_points == 0 || num_points > kMaxPoints) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "the number of points must be between 1 and " + std::to_string(kMaxPoints));
  }
  const double area_m2 = SurfaceArea_m2(mesh);
  if (!(area_m2 > 0.0)) return core::Fail(core::ErrorCode::kInvalidInput, "the mesh has no area to sample");
  SamplingPlan plan;
  plan.spacing_m = std::sqrt(area_m2 / num_points);
  plan.panel_begins = CountPanels(mesh, kPanelSize * plan.spacing_m, workers);
  // A panel and its owner; of a point its candidates with their heap and grid, before there are panels.
  constexpr double kBytesPerPanel = sizeof(SurfacePanel) + sizeof(std::uint32_t);
  constexpr double kBytesPerPoint = 500.0;
  plan.bytes = std::max(kBytesPerPanel * static_cast<double>(plan.panel_begins.back()), kBytesPerPoint * num_points);
  if (plan.bytes <= kMostSamplingBytes) return plan;
  char text[200];
  std::snprintf(text, sizeof text,
                "%u points take about %.3g MB while they are spread, more than the %.3g MB allowed: take fewer",
                num_points, 1e-6 * plan.bytes, 1e-6 * kMostSamplingBytes);
  return core::Fail(core::ErrorCode::kResource, text);
}

core::Result<SurfaceSamples> SampleSurface(const TriangleMesh& mesh, std::uint32_t num_points, const Progress& progress,
                                           core::ParallelFor* workers) {
  const auto plan = PlanSampling(mesh, num_points, workers);
  if (!plan) return tl::unexpected(plan.error());
  auto shell = BuildPointshell(mesh, num_points, progress, workers);
  if (!shell) return tl::unexpected(shell.error());
  return SpreadSamples(mesh, *plan, std::move(*shell), progress, workers);
}

SurfaceSamples SpreadSamples(const TriangleMesh& mesh, const SamplingPlan& plan, Pointshell shell,
                             const Progress& progress, core::ParallelFor* workers) {
  Places places{std::move(shell.points_m), std::move(shell.inward_normals), plan.spacing_m};
  for (glm::dvec3& normal : places.normals) normal = -normal;
  if (progress) progress("points: panels", 0.0);
  const std::vector<SurfacePanel> panels = MakePanels(mesh, kPanelSize * plan.spacing_m, plan.panel_begins, workers);

  std::vector<std::uint32_t> owners;
  std::vector<Cell> cells;
  for (int round = 0; round < kRelaxations; ++round) {
    if (progress) progress("points: areas", static_cast<double>(round) / kRelaxations);
    owners = FindOwners(panels, places, workers);
    cells = SumCells(panels, owners, places.points_m.size(), workers);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (cells[i].area_m2 == 0.0) continue;
      places.points_m[i] = cells[i].place / cells[i].area_m2;
      if (glm::length(cells[i].normal) > 0.0) places.normals[i] = glm::normalize(cells[i].normal);
    }
  }
  SurfaceSamples samples;
  double given_m2 = 0.0;
  for (const Cell& cell : cells) given_m2 += cell.area_m2;
  const double scale = SurfaceArea_m2(mesh) / given_m2;  // what is nobody's is shared among all
  for (std::size_t i = 0; i < cells.size(); ++i) {
    samples.points_m.push_back(places.points_m[i]);
    samples.inward_normals.push_back(cells[i].area_m2 > 0.0 ? -cells[i].normal / cells[i].area_m2 : -places.normals[i]);
    samples.areas_m2.push_back(cells[i].area_m2 * scale);
  }
  samples.reach_m = FindReach_m(panels, owners, samples.points_m, workers);
  return samples;
}

}  // namespace vps
