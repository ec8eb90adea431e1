#include "vps/sampling/panel_owners.hpp"

#include <algorithm>
#include <cmath>

#include "vps/sampling/graded_grid.hpp"

namespace vps {
namespace {

// Not derived: panels whose normal differs by more belong to another face (cosine of 45 degrees).
constexpr double kSameFace = 0.7071;

// Points are searched within so many spacings, counted half from the panel's own and half from theirs; first as far as
// nearly all panels find theirs.
constexpr double kFirstFactor = 1.4;
constexpr double kLastFactor = 4.0;

// What is found so far. Of points equally near, the first.
struct Nearest {
  std::uint32_t point = kNobody;
  double squared_m2 = 1e300;

  [[nodiscard]] bool IsBeatenBy(std::uint32_t i, double squared) const {
    return squared < squared_m2 || (squared == squared_m2 && i < point);
  }
};

std::uint32_t OwnerOf(const SurfacePanel& panel, const Places& places, const GradedGrid& grid) {
  Nearest of_face;
  Nearest of_any;
  for (const double factor : {kFirstFactor, kLastFactor}) {
    grid.ForNear(panel.centroid_m, panel.spacing_m, factor, [&](std::uint32_t i) {
      const glm::dvec3 r = places.points_m[i] - panel.centroid_m;
      const double squared = glm::dot(r, r);
      if (of_any.IsBeatenBy(i, squared)) of_any = {i, squared};
      if (!of_face.IsBeatenBy(i, squared) || glm::dot(places.normals[i], panel.normal) < kSameFace) return;
      of_face = {i, squared};
    });
    if (of_face.squared_m2 <= std::pow(0.5 * factor * panel.spacing_m, 2)) break;
  }
  return of_face.point != kNobody ? of_face.point : of_any.point;
}

// Neighbouring panels have the same few points around them, which are looked up once for a run of panels. OwnerOf finds
// the nearest point of the panel's face, and looks at all that are nearer than kLastFactor / 2 (h + 0.4 h) = 2.8 h,
// with h the panel's spacing: one found within kReach h is that point. The few panels without ask OwnerOf.
class RunOfPanels {
 public:
  RunOfPanels(const Places& places, const GradedGrid& grid) : places_(places), grid_(grid) {}

  // Of the panels [begin, end), which follow each other along the surface.
  void FindOwners(const std::vector<SurfacePanel>& panels, std::size_t begin, std::size_t end, std::uint32_t* owners) {
    for (std::size_t first = begin, last = begin; first < end; first = last) {
      last = EndOfRun(panels, first, end);
      GatherAround();
      for (std::size_t i = first; i < last; ++i) {
        const std::uint32_t owner = Find(panels[i]);
        owners[i] = owner != kNobody ? owner : OwnerOf(panels[i], places_, grid_);
      }
    }
  }

 private:
  // Of the spacing: the diagonal of a run's box, and how far points are looked for. Free: longer runs have more points
  // around, shorter ones are more (of 1.2, 2 and 3, 3 took a sixth less time than 1.2); what is not found within the
  // reach takes longer.
  static constexpr double kRun = 3.0;
  static constexpr double kReach = 1.0;

  std::size_t EndOfRun(const std::vector<SurfacePanel>& panels, std::size_t first, std::size_t end) {
    box_ = {panels[first].centroid_m, panels[first].centroid_m};
    least_m_ = most_m_ = panels[first].spacing_m;
    std::size_t i = first + 1;
    for (; i < end; ++i) {
      const SurfacePanel& panel = panels[i];
      const Box box{glm::min(box_.lower, panel.centroid_m), glm::max(box_.upper, panel.centroid_m)};
      const double least_m = std::min(least_m_, panel.spacing_m);
      const glm::dvec3 size = box.upper - box.lower;
      if (glm::dot(size, size) > kRun * kRun * least_m * least_m) break;
      box_ = box;
      least_m_ = least_m;
      most_m_ = std::max(most_m_, panel.spacing_m);
    }
    return i;
  }

  // The points that are nearer than kReach of the largest spacing to the run's box.
  void GatherAround() {
    around_.clear();
    constexpr double kPad = 1.0 + 1e-9;  // against rounding
    const double reach_m = kReach * most_m_ * kPad;
    grid_.ForNearBox(box_.lower, box_.upper, reach_m, least_m_, most_m_, [&](std::uint32_t i, double level_m) {
      const glm::dvec3& p = places_.points_m[i];
      const glm::dvec3 out = glm::max(glm::max(box_.lower - p, p - box_.upper), 0.0);
      if (glm::dot(out, out) <= reach_m * reach_m) around_.push_back({p, places_.normals[i], level_m, i});
    });
  }

  [[nodiscard]] std::uint32_t Find(const SurfacePanel& panel) const {
    const double reach_m = kReach * panel.spacing_m;
    Nearest nearest{kNobody, reach_m * reach_m};
    for (const Point& point : around_) {
      const glm::dvec3 r = point.p_m - panel.centroid_m;
      const double squared = glm::dot(r, r);
      if (!nearest.IsBeatenBy(point.number, squared)) continue;
      if (!GradedGrid::IsSearched(point.level_m, panel.spacing_m)) continue;
      if (glm::dot(point.normal, panel.normal) < kSameFace) continue;
      nearest = {point.number, squared};
    }
    return nearest.point;
  }

  struct Point {
    glm::dvec3 p_m, normal;
    double level_m;
    std::uint32_t number;
  };
  const Places& places_;
  const GradedGrid& grid_;
  Box box_{};                            // of the run's centroids
  double least_m_ = 0.0, most_m_ = 0.0;  // spacings
  std::vector<Point> around_;
};

}  // namespace

std::vector<std::uint32_t> FindOwners(const std::vector<SurfacePanel>& panels, const Places& places,
                                      core::ParallelFor* workers) {
  constexpr std::size_t kPanelsOfBlock = 4096;  // free: as kTrianglesOfBlock
  const GradedGrid grid(places.points_m, places.spacings_m);
  std::vector<std::uint32_t> owners(panels.size());
  core::ForEach(workers, (panels.size() + kPanelsOfBlock - 1) / kPanelsOfBlock, [&](std::size_t block) {
    const std::size_t end = std::min((block + 1) * kPanelsOfBlock, panels.size());
    RunOfPanels(places, grid).FindOwners(panels, block * kPanelsOfBlock, end, owners.data());
  });
  return owners;
}

}  // namespace vps
