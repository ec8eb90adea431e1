#include "vps/sampling/panel_owners.hpp"

#include <algorithm>

#include "vps/pointshell/point_grid.hpp"

namespace vps {
namespace {

// Not derived: panels whose normal differs by more belong to another face (cosine of 45 degrees).
constexpr double kSameFace = 0.7071;

// A place across the plane counts as so many times farther. Not derived: over the radius of curvature R a neighbour at
// one spacing h lies h^2 / 2R off the plane, which has to stay below h for cells of all bodies that h resolves.
constexpr double kAcross = 4.0;

// Points are searched within one spacing, where nearly all panels find theirs, then within three: the gaps of blue
// noise are narrower, those of a face's own points next to an edge included.
constexpr double kReaches[] = {1.0, 3.0};

// Of points equally near, the first.
struct Nearest {
  std::uint32_t point = kNobody;
  double squared_m2 = 1e300;

  void Meet(std::uint32_t i, double squared) {
    if (squared < squared_m2 || (squared == squared_m2 && i < point)) *this = {i, squared};
  }
};

std::uint32_t OwnerOf(const SurfacePanel& panel, const Places& places, const PointGrid& grid) {
  Nearest of_any;
  for (const double reach : kReaches) {
    const double reach_m = reach * places.spacing_m;
    Nearest of_face;
    grid.ForNear(panel.centroid_m, reach_m, [&](std::uint32_t i) {
      const glm::dvec3 r = places.points_m[i] - panel.centroid_m;
      const double squared = glm::dot(r, r);
      of_any.Meet(i, squared);
      const double across = kAcross * glm::dot(panel.normal, r);
      if (glm::dot(places.normals[i], panel.normal) >= kSameFace) of_face.Meet(i, squared + across * across);
    });
    // Points out of the search's reach are farther.
    if (of_face.squared_m2 <= reach_m * reach_m) return of_face.point;
  }
  return of_any.point;
}

}  // namespace

std::vector<std::uint32_t> FindOwners(const std::vector<SurfacePanel>& panels, const Places& places,
                                      core::ParallelFor* workers) {
  constexpr std::size_t kPanelsOfBlock = 4096;  // free: enough blocks for all workers
  const PointGrid grid(places.points_m, places.spacing_m);
  std::vector<std::uint32_t> owners(panels.size());
  core::ForEach(workers, (panels.size() + kPanelsOfBlock - 1) / kPanelsOfBlock, [&](std::size_t block) {
    const std::size_t end = std::min((block + 1) * kPanelsOfBlock, panels.size());
    for (std::size_t i = block * kPanelsOfBlock; i < end; ++i) owners[i] = OwnerOf(panels[i], places, grid);
  });
  return owners;
}

}  // namespace vps
