#pragma once

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace vps {

// Points sorted into cubic cells behind a hash table, for neighbour search while building. Order of visit depends only
// on the points.
class PointGrid {
 public:
  PointGrid(const std::vector<glm::dvec3>& points, double cell_size_m) : inverse_cell_(1.0 / cell_size_m) {
    std::size_t num_buckets = 64;
    while (num_buckets < 2 * points.size()) num_buckets *= 2;
    mask_ = num_buckets - 1;
    starts_.assign(num_buckets + 1, 0);
    for (const auto& p : points) ++starts_[Bucket(CellOf(p)) + 1];
    for (std::size_t b = 0; b < num_buckets; ++b) starts_[b + 1] += starts_[b];
    items_.resize(points.size());
    std::vector<std::uint32_t> next(starts_.begin(), starts_.end() - 1);
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      const glm::ivec3 cell = CellOf(points[i]);
      items_[next[Bucket(cell)]++] = {cell, i};
    }
  }

  [[nodiscard]] glm::ivec3 CellOf(const glm::dvec3& p) const { return glm::ivec3(glm::floor(p * inverse_cell_)); }

  // Calls visit(index) for every point in the cells whose largest coordinate difference to `centre` is `ring`.
  template <typename Visit>
  void ForRing(const glm::ivec3& centre, int ring, Visit&& visit) const {
    glm::ivec3 cell;
    for (cell.z = centre.z - ring; cell.z <= centre.z + ring; ++cell.z) {
      for (cell.y = centre.y - ring; cell.y <= centre.y + ring; ++cell.y) {
        const bool is_face = std::abs(cell.z - centre.z) == ring || std::abs(cell.y - centre.y) == ring;
        const int step = is_face || ring == 0 ? 1 : 2 * ring;
        for (cell.x = centre.x - ring; cell.x <= centre.x + ring; cell.x += step) ForCell(cell, visit);
      }
    }
  }

  // Calls visit(index) for every point closer than `radius_m`, and some farther ones.
  template <typename Visit>
  void ForNear(const glm::dvec3& p, double radius_m, Visit&& visit) const {
    const glm::ivec3 lower = CellOf(p - radius_m);
    const glm::ivec3 upper = CellOf(p + radius_m);
    for (int z = lower.z; z <= upper.z; ++z) {
      for (int y = lower.y; y <= upper.y; ++y) ForRow({lower.x, y, z}, upper.x, visit);
    }
  }

 private:
  template <typename Visit>
  void ForCell(const glm::ivec3& cell, Visit&& visit) const {
    const std::size_t bucket = Bucket(cell);
    for (std::uint32_t k = starts_[bucket]; k < starts_[bucket + 1]; ++k) {
      if (items_[k].cell == cell) visit(items_[k].point);  // other cells may share the bucket
    }
  }

  // Calls visit(index) for every point in the cells from `first` along x to `last_x`. Their buckets follow each other
  // in the table, so that all are read in one go, unless the row runs over the table's end.
  template <typename Visit>
  void ForRow(const glm::ivec3& first, int last_x, Visit&& visit) const {
    const std::size_t begin = Bucket(first);
    const std::size_t end = begin + static_cast<std::size_t>(last_x - first.x) + 1;
    if (end >= starts_.size()) {
      for (glm::ivec3 cell = first; cell.x <= last_x; ++cell.x) ForCell(cell, visit);
      return;
    }
    for (std::uint32_t k = starts_[begin]; k < starts_[end]; ++k) {
      const glm::ivec3& cell = items_[k].cell;
      if (cell.y == first.y && cell.z == first.z && first.x <= cell.x && cell.x <= last_x) visit(items_[k].point);
    }
  }

  // Cells that are neighbours along x have neighbouring buckets: searches go row by row.
  [[nodiscard]] std::size_t Bucket(const glm::ivec3& c) const {
    std::uint64_t h = static_cast<std::uint32_t>(c.y) * 0xc2b2ae3d27d4eb4fULL;
    h ^= static_cast<std::uint32_t>(c.z) * 0x165667b19e3779f9ULL;
    h ^= h >> 29;
    return (static_cast<std::size_t>(h * 0xbf58476d1ce4e5b9ULL >> 20) + static_cast<std::uint32_t>(c.x)) & mask_;
  }

  struct Item {
    glm::ivec3 cell;
    std::uint32_t point;
  };
  double inverse_cell_;
  std::size_t mask_ = 0;
  std::vector<std::uint32_t> starts_;
  std::vector<Item> items_;
};

}  // namespace vps
