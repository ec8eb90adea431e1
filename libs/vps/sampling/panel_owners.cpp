#include "vps/sampling/panel_owners.hpp"

#include <algorithm>
#include <limits>

#include "vps/pointshell/point_grid.hpp"

namespace vps {
namespace {

// Not derived: panels whose normal differs by more belong to another face (cosine of 45 degrees).
constexpr double kSameFace = 0.7071;

// A place across the plane counts as so many times farther. Not derived: over the radius of curvature R a neighbour at
// one spacing h lies h^2 / 2R off the plane, which has to stay below h for cells of all bodies that h resolves.
constexpr double kAcross = 4.0;

// Of its face, points are searched within one spacing, where nearly all panels find theirs, then within 1.5: the gaps
// of blue noise are narrower, those of a face's own points next to an edge included. A narrow face has none then, and
// its panels join what is nearest, within 3. Not derived.
constexpr double kOfFace[] = {1.0, 1.5};
constexpr double kOfAny = 3.0;

// Of points equally near, the first.
struct Nearest {
  std::uint32_t point = kNobody;
  double squared_m2 = 1e300;

  void Meet(std::uint32_t i, double squared) {
    if (squared < squared_m2 || (squared == squared_m2 && i < point)) *this = {i, squared};
  }
};

std::uint32_t OwnerOf(const SurfacePanel& panel, const Places& places, const PointGrid& grid) {
  Nearest nearest;
  // Points out of a search's reach are farther.
  const auto has_found = [&](double reach, const auto& squared_of) {
    const double reach_m = reach * places.spacing_m;
    nearest = {};
    grid.ForNear(panel.centroid_m, reach_m,
                 [&](std::uint32_t i) { nearest.Meet(i, squared_of(i, places.points_m[i] - panel.centroid_m)); });
    return nearest.squared_m2 <= reach_m * reach_m;
  };
  const auto of_face = [&](std::uint32_t i, const glm::dvec3& r) {
    if (glm::dot(places.normals[i], panel.normal) < kSameFace) return std::numeric_limits<double>::infinity();
    const double across = kAcross * glm::dot(panel.normal, r);
    return glm::dot(r, r) + across * across;
  };
  for (const double reach : kOfFace) {
    if (has_found(reach, of_face)) return nearest.point;
  }
  for (const double reach : {kOfFace[0], kOfFace[1], kOfAny}) {
    if (has_found(reach, [](std::uint32_t, const glm::dvec3& r) { return glm::dot(r, r); })) break;
  }
  return nearest.point;
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
