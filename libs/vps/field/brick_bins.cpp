#include "vps/field/brick_bins.hpp"

#include <algorithm>
#include <cmath>

#include "vps/field/distance_field.hpp"

namespace vps {
namespace {

constexpr double kHalf = 0.5 * (DistanceField::kBrick - 1);  // of the box of a brick's samples

// Calls visit(slot) for the bricks whose box of samples may come within `reach` of the triangle: boxes overlap, the
// box reaches the plane, and, for a triangle of many bricks, the sphere around the box reaches the triangle.
template <class Visit>
void ForEachBrick(const TriangleField& triangles, std::uint32_t t, const glm::ivec3& grid, double reach,
                  Visit&& visit) {
  const auto& [a, b, c] = triangles.corners(t);
  const double widen = reach + kHalf;
  const auto brick_of = [](double at) { return at / DistanceField::kBrick; };
  const glm::dvec3 lower = glm::min(a, glm::min(b, c)) - widen;
  const glm::dvec3 upper = glm::max(a, glm::max(b, c)) + widen;
  // Brick i has its centre at 8 i + 4.
  glm::ivec3 first;
  glm::ivec3 last;
  for (int axis = 0; axis < 3; ++axis) {
    first[axis] = std::max(static_cast<int>(std::ceil(brick_of(lower[axis]) - 0.5)), 0);
    last[axis] = std::min(static_cast<int>(std::floor(brick_of(upper[axis]) - 0.5)), grid[axis] - 1);
  }
  const glm::dvec3 n = triangles.normal(t);  // zero for a triangle without area, whose plane is undefined
  const double offset = glm::dot(n, a);
  const double slab = reach + kHalf * (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
  const double sphere = reach + kHalf * 1.7320508075688773;
  const glm::ivec3 size = last - first + 1;
  const bool is_large = size.x * size.y * size.z > 8;
  for (int z = first.z; z <= last.z; ++z) {
    for (int y = first.y; y <= last.y; ++y) {
      for (int x = first.x; x <= last.x; ++x) {
        const glm::dvec3 centre = glm::dvec3(x, y, z) * static_cast<double>(DistanceField::kBrick) + 4.0;
        if (std::abs(glm::dot(n, centre) - offset) > slab) continue;
        if (is_large && triangles.Closest(t, centre).squared_distance > sphere * sphere) continue;
        visit((static_cast<std::size_t>(z) * grid.y + y) * grid.x + x);
      }
    }
  }
}

}  // namespace

BrickBins BinTriangles(const TriangleField& triangles, const glm::ivec3& grid_bricks, double reach,
                       std::vector<std::uint32_t>* scratch) {
  BrickBins bins;
  std::vector<std::uint32_t>& count = *scratch;
  count.assign(static_cast<std::size_t>(grid_bricks.x) * grid_bricks.y * grid_bricks.z, 0);
  const auto num_triangles = static_cast<std::uint32_t>(triangles.num_triangles());
  for (std::uint32_t t = 0; t < num_triangles; ++t) {
    ForEachBrick(triangles, t, grid_bricks, reach, [&](std::size_t slot) { ++count[slot]; });
  }
  std::size_t num_bricks = 0;
  for (const std::uint32_t c : count) num_bricks += c != 0 ? 1 : 0;
  bins.slot_of_brick.reserve(num_bricks);
  bins.first.reserve(num_bricks + 1);
  std::uint32_t sum = 0;
  for (std::size_t slot = 0; slot < count.size(); ++slot) {
    const std::uint32_t here = count[slot];
    count[slot] = kNoBrick;
    if (here == 0) continue;
    count[slot] = static_cast<std::uint32_t>(bins.num_bricks());
    bins.slot_of_brick.push_back(static_cast<std::uint32_t>(slot));
    bins.first.push_back(sum);
    sum += here;
  }
  bins.first.push_back(sum);
  bins.triangles.resize(sum);
  std::vector<std::uint32_t> next(bins.first.begin(), bins.first.end() - 1);
  for (std::uint32_t t = 0; t < num_triangles; ++t) {
    ForEachBrick(triangles, t, grid_bricks, reach, [&](std::size_t slot) { bins.triangles[next[count[slot]]++] = t; });
  }
  return bins;
}

}  // namespace vps
