#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "vps/pointshell/point_grid.hpp"

namespace vps {

// Points whose spacing varies, sorted into one PointGrid for each octave of spacing. Neighbours' spacings are close, so
// that a search needs only the octaves around its own.
class GradedGrid {
 public:
  GradedGrid(const std::vector<glm::dvec3>& points, const std::vector<double>& spacings_m) {
    for (const double h : spacings_m) largest_m_ = std::max(largest_m_, h);
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      const std::size_t level = LevelOf(spacings_m[i]);
      while (levels_.size() <= level) levels_.push_back(std::make_unique<Level>());
      levels_[level]->points.push_back(points[i]);
      levels_[level]->ids.push_back(i);
    }
    for (std::size_t k = 0; k < levels_.size(); ++k) {
      Level& level = *levels_[k];
      level.spacing_m = std::ldexp(largest_m_, -static_cast<int>(k));
      level.grid = std::make_unique<PointGrid>(level.points, 2.0 * level.spacing_m);
    }
  }

  // Calls visit(index) for every point closer to p than factor (h + its own spacing) / 2, and some farther ones, if its
  // spacing is between 0.4 h and 2 h.
  template <typename Visit>
  void ForNear(const glm::dvec3& p, double h_m, double factor, Visit&& visit) const {
    for (const auto& level : levels_) {
      if (!IsSearched(level->spacing_m, h_m) || level->points.empty()) continue;
      level->grid->ForNear(p, 0.5 * factor * (h_m + level->spacing_m), [&](std::uint32_t k) { visit(level->ids[k]); });
    }
  }

  // Whether a search from a place of spacing h looks at the octave of this largest spacing.
  [[nodiscard]] static bool IsSearched(double level_m, double h_m) {
    return level_m >= 0.4 * h_m && level_m <= 4.0 * h_m;
  }

  // Calls visit(index, largest spacing of its octave) for every point closer than radius_m to the box, and few farther
  // ones, of the octaves that searches from places of spacings between `least_m` and `most_m` look at.
  template <typename Visit>
  void ForNearBox(const glm::dvec3& lower, const glm::dvec3& upper, double radius_m, double least_m, double most_m,
                  Visit&& visit) const {
    for (const auto& level : levels_) {
      if (level->spacing_m < 0.4 * least_m || level->spacing_m > 4.0 * most_m || level->points.empty()) continue;
      level->grid->ForNearBox(lower, upper, radius_m, [&](std::uint32_t k) { visit(level->ids[k], level->spacing_m); });
    }
  }

 private:
  struct Level {
    double spacing_m = 0.0;  // largest
    std::vector<glm::dvec3> points;
    std::vector<std::uint32_t> ids;
    std::unique_ptr<PointGrid> grid;
  };
  [[nodiscard]] std::size_t LevelOf(double h) const {
    return static_cast<std::size_t>(std::max(0.0, std::floor(std::log2(largest_m_ / h))));
  }

  double largest_m_ = 0.0;
  std::vector<std::unique_ptr<Level>> levels_;
};

}  // namespace vps
