#pragma once

#include <algorithm>
#include <glm/glm.hpp>
#include <vector>

#include "vps/field/distance_field.hpp"

namespace vps {

// What the surface around each brick is like in the mean, weighted by a tent two bricks wide.
class BrickMeans {
 public:
  explicit BrickMeans(const DistanceField& layout)
      : n_(glm::ivec3(layout.nx, layout.ny, layout.nz) / DistanceField::kBrick),
        sums_(static_cast<std::size_t>(n_.x) * static_cast<std::size_t>(n_.y) * static_cast<std::size_t>(n_.z)) {}

  // Calls visit(brick, its share) for the eight whose middles are around p, in voxels. Shares add up to 1.
  template <typename Visit>
  static void ForBricksAround(const glm::vec3& p, const glm::ivec3& n, const Visit& visit) {
    const glm::vec3 q = p / static_cast<float>(DistanceField::kBrick) - 0.5f;
    const glm::ivec3 corner(glm::floor(q));
    const glm::vec3 f = q - glm::vec3(corner);
    for (int k = 0; k < 8; ++k) {
      const glm::ivec3 step(k & 1, k >> 1 & 1, k >> 2);
      const glm::ivec3 at = glm::clamp(corner + step, glm::ivec3(0), n - 1);
      const glm::vec3 share = glm::mix(1.0f - f, f, glm::vec3(step));
      visit(static_cast<std::size_t>((at.z * n.y + at.y) * n.x + at.x), share.x * share.y * share.z);
    }
  }

  // An area of surface at p, and what there is to it.
  void Add(const glm::dvec3& p, double area, double what) {
    ForBricksAround(glm::vec3(p), n_, [&](std::size_t brick, float share) {
      sums_[brick] += glm::vec2(glm::dvec2(area, what) * static_cast<double>(share));
    });
  }

  [[nodiscard]] std::size_t size() const { return sums_.size(); }
  // What there is per area; 0 where there is no surface.
  [[nodiscard]] double mean(std::size_t brick) const {
    const glm::vec2& sum = sums_[brick];
    return sum.x > 0.0f ? static_cast<double>(sum.y / sum.x) : 0.0;
  }

 private:
  glm::ivec3 n_;
  std::vector<glm::vec2> sums_;
};

// Calls visit(a, b, c) for the parts of a triangle, halved across its longest side until that is no longer than
// `longest`.
template <typename Visit>
void ForParts(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, double longest, const Visit& visit) {
  const double sides[3] = {glm::length(b - a), glm::length(c - b), glm::length(a - c)};
  const int k = static_cast<int>(std::max_element(sides, sides + 3) - sides);
  if (sides[k] <= longest) {
    visit(a, b, c);
    return;
  }
  const glm::dvec3 around[5] = {a, b, c, a, b};
  const glm::dvec3 middle = 0.5 * (around[k] + around[k + 1]);
  ForParts(around[k], middle, around[k + 2], longest, visit);
  ForParts(middle, around[k + 1], around[k + 2], longest, visit);
}

}  // namespace vps
