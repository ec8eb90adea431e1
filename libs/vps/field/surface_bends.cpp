#include "vps/field/surface_bends.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "vps/field/brick_means.hpp"

namespace vps {
namespace {

constexpr double kLongestPiece = 0.5 * DistanceField::kBrick;  // voxels

// An edge that turns more is none of a round surface: creases and graded samples see to it.
constexpr double kSharp_rad = 25.0 / 180.0 * std::numbers::pi;

void AddEdge(const glm::dvec3& a, const glm::dvec3& b, double turn, BrickMeans* means) {
  const double length = glm::length(b - a);
  const int pieces = static_cast<int>(length / kLongestPiece) + 1;
  for (int i = 0; i < pieces; ++i) means->Add(glm::mix(a, b, (i + 0.5) / pieces), 0.0, turn * length / pieces);
}

std::vector<std::int16_t> Encode(const BrickMeans& means) {
  std::vector<std::int16_t> bends((means.size() + 1) / 2 * 2, 0);  // kernels read two at once
  constexpr double kMost = 32767.0;
  for (std::size_t i = 0; i < means.size(); ++i) {
    const double steps = means.mean(i) / static_cast<double>(kBendStep);
    bends[i] = static_cast<std::int16_t>(std::lround(std::clamp(steps, -kMost, kMost)));
  }
  return bends;
}

}  // namespace

std::vector<std::int16_t> SurfaceBends(const TriangleField& triangles, const DistanceField& layout) {
  BrickMeans means(layout);
  for (std::uint32_t t = 0; t < triangles.num_triangles() && !triangles.is_sheet(); ++t) {
    const auto corners = triangles.corners(t);
    const glm::dvec3& n = triangles.normal(t);
    if (n == glm::dvec3(0.0)) continue;
    ForParts(corners[0], corners[1], corners[2], kLongestPiece, [&](const auto& a, const auto& b, const auto& c) {
      means.Add((a + b + c) / 3.0, 0.5 * glm::length(glm::cross(b - a, c - a)), 0.0);
    });
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3& a = corners[static_cast<std::size_t>(k)];
      const glm::dvec3& b = corners[static_cast<std::size_t>((k + 1) % 3)];
      // Of an edge that bulges the neighbour's normal leans out of this face. Each side adds half of the turn.
      const glm::dvec3 other = triangles.neighbour_normal(t, k);
      if (glm::dot(other, other) < 0.5) continue;  // the surface's border
      const double out = glm::dot(other, glm::normalize(glm::cross(b - a, n)));
      const double turn = std::atan2(out, glm::dot(other, n));
      if (std::abs(turn) < kSharp_rad) AddEdge(a, b, 0.5 * turn, &means);
    }
  }
  return Encode(means);
}

}  // namespace vps
