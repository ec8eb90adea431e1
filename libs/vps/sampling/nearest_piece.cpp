#include "vps/sampling/nearest_piece.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "vps/mesh/nearest_on_triangle.hpp"

namespace vps {
namespace {

// Squared distances that differ by less, relatively, are to one place: the rounding of pieces' corners to floats.
constexpr double kSamePlace = 1e-6;

struct Search {
  const SurfacePieces& pieces;
  glm::dvec3 p;
  glm::dvec3 q;
  double squared;
  NearestPiece nearest;
  double height_of_q = 0.0;  // above the nearest one's plane

  // The nearest spheres first, so that the others are passed over sooner.
  void MeetLevel(std::uint32_t level, std::uint32_t index) {
    const SphereBlock& block = pieces.spheres[pieces.level_begin[level] + index];
    const glm::vec3 at(p);
    std::array<float, kBlock> way_squared;
    unsigned near = 0;
    const auto is_near = [&](std::uint32_t k) {
      const float reach = block.r[k] + static_cast<float>(std::sqrt(squared)) * kPad;
      return way_squared[k] < reach * reach;
    };
    for (std::uint32_t k = 0; k < kBlock; ++k) {
      const glm::vec3 way(block.x[k] - at.x, block.y[k] - at.y, block.z[k] - at.z);
      way_squared[k] = glm::dot(way, way);
      near |= (is_near(k) ? 1U : 0U) << k;
    }
    while (near != 0) {
      auto best = static_cast<std::uint32_t>(__builtin_ctz(near));
      for (unsigned rest = near & (near - 1); rest != 0; rest &= rest - 1) {
        const auto k = static_cast<std::uint32_t>(__builtin_ctz(rest));
        if (way_squared[k] < way_squared[best]) best = k;
      }
      near &= ~(1U << best);
      if (!is_near(best)) continue;
      const std::uint32_t child = index * kBlock + best;
      if (level > 0) {
        MeetLevel(level - 1, child);
      } else {
        Meet(pieces.pieces[child]);
      }
    }
  }
  void Meet(const SurfacePiece& piece) {
    const glm::dvec3 a = glm::dvec3(piece.corners[0]) - p;
    const glm::dvec3 b = glm::dvec3(piece.corners[1]) - p;
    const glm::dvec3 c = glm::dvec3(piece.corners[2]) - p;
    const glm::dvec3 n = glm::cross(b - a, c - a);
    const double h = glm::dot(n, a);
    const double nn = glm::dot(n, n);
    if (h > 0.0 || h * h >= squared * (1.0 + kSamePlace) * nn) return;
    const OnTriangle on = NearestOnTriangle(a, b, c, n);
    const double found = glm::dot(on.place, on.place);
    const double above = kSamePlace * squared;
    if (found >= (nearest.is_found ? squared + above : squared)) return;
    const glm::dvec3 outward = n / std::sqrt(nn);
    const double height = glm::dot(q - p - a, outward);
    if (nearest.is_found && found > squared - above && height <= height_of_q) return;
    squared = std::min(found, squared);
    nearest = {true, on.is_on_face, p + on.place, outward};
    height_of_q = height;
  }

  static constexpr float kPad = 1.0f + 1e-5f;  // against the rounding of floats
};

}  // namespace

NearestPiece FindNearestPiece(const SurfacePieces& pieces, const glm::dvec3& p, const glm::dvec3& q,
                              double reach_m) noexcept {
  if (pieces.num_levels == 0) return {};
  Search search{pieces, p, q, reach_m * reach_m, {}};
  search.MeetLevel(pieces.num_levels - 1, 0);
  return search.nearest;
}

NearestPiece FindNearestPiece(const SurfacePieces& pieces, const glm::dvec3& p, double reach_m) noexcept {
  return FindNearestPiece(pieces, p, p, reach_m);
}

}  // namespace vps
