#include "vps/field/surface_bends.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace vps {
namespace {

constexpr double kLongestPiece = 0.5 * DistanceField::kBrick;  // voxels

// An edge that turns more is none of a round surface: creases and graded samples see to it.
constexpr double kSharp_rad = 25.0 / 180.0 * std::numbers::pi;

// What lies around each brick: area, and turn of the normal times length.
class BrickSums {
 public:
  explicit BrickSums(const DistanceField& layout)
      : n_(glm::ivec3(layout.nx, layout.ny, layout.nz) / DistanceField::kBrick),
        sums_(static_cast<std::size_t>(n_.x) * n_.y * n_.z) {}

  // Shared out among the eight bricks whose middles are around p.
  void Add(const glm::dvec3& p, const glm::dvec2& what) {
    const glm::dvec3 q = p / static_cast<double>(DistanceField::kBrick) - 0.5;
    const glm::ivec3 corner(glm::floor(q));
    const glm::dvec3 f = q - glm::dvec3(corner);
    for (int k = 0; k < 8; ++k) {
      const glm::ivec3 step(k & 1, k >> 1 & 1, k >> 2);
      const glm::ivec3 at = glm::clamp(corner + step, glm::ivec3(0), n_ - 1);
      const glm::dvec3 share = glm::mix(1.0 - f, f, glm::dvec3(step));
      sums_[(static_cast<std::size_t>(at.z) * n_.y + at.y) * n_.x + at.x] +=
          glm::vec2(what * (share.x * share.y * share.z));
    }
  }

  void AddTriangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const double sides[3] = {glm::length(b - a), glm::length(c - b), glm::length(a - c)};
    const int k = static_cast<int>(std::max_element(sides, sides + 3) - sides);
    if (sides[k] <= kLongestPiece) {
      Add((a + b + c) / 3.0, {0.5 * glm::length(glm::cross(b - a, c - a)), 0.0});
      return;
    }
    const std::array<glm::dvec3, 5> around{a, b, c, a, b};
    const glm::dvec3 middle = 0.5 * (around[k] + around[k + 1]);
    AddTriangle(around[k], middle, around[k + 2]);
    AddTriangle(middle, around[k + 1], around[k + 2]);
  }

  void AddEdge(const glm::dvec3& a, const glm::dvec3& b, double turn) {
    const double length = glm::length(b - a);
    const int pieces = static_cast<int>(length / kLongestPiece) + 1;
    for (int i = 0; i < pieces; ++i) Add(glm::mix(a, b, (i + 0.5) / pieces), {0.0, turn * length / pieces});
  }

  [[nodiscard]] std::vector<std::int16_t> Bends() const {
    std::vector<std::int16_t> bends((sums_.size() + 1) / 2 * 2, 0);  // kernels read two at once
    constexpr double kMost = 32767.0;
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      if (!(sums_[i].x > 0.0f)) continue;
      const double steps = static_cast<double>(sums_[i].y / sums_[i].x) / static_cast<double>(kBendStep);
      bends[i] = static_cast<std::int16_t>(std::lround(std::clamp(steps, -kMost, kMost)));
    }
    return bends;
  }

 private:
  glm::ivec3 n_;
  std::vector<glm::vec2> sums_;
};

}  // namespace

std::vector<std::int16_t> SurfaceBends(const TriangleField& triangles, const DistanceField& layout) {
  BrickSums sums(layout);
  for (std::uint32_t t = 0; t < triangles.num_triangles() && !triangles.is_sheet(); ++t) {
    const auto corners = triangles.corners(t);
    const glm::dvec3& n = triangles.normal(t);
    if (n == glm::dvec3(0.0)) continue;
    sums.AddTriangle(corners[0], corners[1], corners[2]);
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3& a = corners[static_cast<std::size_t>(k)];
      const glm::dvec3& b = corners[static_cast<std::size_t>((k + 1) % 3)];
      // Of an edge that bulges the neighbour's normal leans out of this face. Each side adds half of the turn.
      const glm::dvec3 other = triangles.neighbour_normal(t, k);
      if (glm::dot(other, other) < 0.5) continue;  // the surface's border
      const double out = glm::dot(other, glm::normalize(glm::cross(b - a, n)));
      const double turn = std::atan2(out, glm::dot(other, n));
      if (std::abs(turn) < kSharp_rad) sums.AddEdge(a, b, 0.5 * turn);
    }
  }
  return sums.Bends();
}

}  // namespace vps
