#include "vps/surface/nearest_place.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "vps/mesh/nearest_on_triangle.hpp"

namespace vps {
namespace {

// Squared distances that differ by less, relatively, are to one place: the rounding of pieces' corners to floats.
constexpr double kSamePlace = 1e-6;

struct Search {
  const SurfaceTree& surface;
  glm::dvec3 p;
  glm::dvec3 q;
  double squared;
  NearestPlace nearest;
  double height_of_q = 0.0;  // above the nearest one's plane

  // The nearest nodes first, so that the others are passed over sooner.
  void MeetNodes(std::uint32_t first, std::uint32_t count) {
    struct Way {
      double least_m;  // of the node's ball
      std::uint32_t node;
    };
    std::array<Way, kFamilySize> ways;
    for (std::uint32_t k = 0; k < count; ++k) {
      const SurfaceNode& node = surface.nodes[first + k];
      const double centre_m = glm::length(glm::dvec3(node.centre_m) - p);
      ways[k] = {centre_m - static_cast<double>(node.radius_m) * kPad, first + k};
    }
    std::sort(ways.begin(), ways.begin() + count, [](const Way& a, const Way& b) { return a.least_m < b.least_m; });
    for (std::uint32_t k = 0; k < count; ++k) {
      if (ways[k].least_m > 0.0 && ways[k].least_m * ways[k].least_m > squared * (1.0 + kSamePlace)) return;
      const SurfaceNode& node = surface.nodes[ways[k].node];
      if (node.num_children == 0) {
        Meet(surface.triangles[node.first]);
      } else {
        MeetNodes(node.first, node.num_children);
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
    nearest = {true, p + on.place, outward};
    height_of_q = height;
  }

  static constexpr double kPad = 1.0 + 1e-5;  // against the rounding of floats
};

}  // namespace

NearestPlace FindNearestPlace(const SurfaceTree& surface, const glm::dvec3& p, const glm::dvec3& q,
                              double reach_m) noexcept {
  Search search{surface, p, q, reach_m * reach_m, {}};
  search.MeetNodes(0, surface.num_roots);
  return search.nearest;
}

}  // namespace vps
