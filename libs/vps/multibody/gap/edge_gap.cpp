#include "vps/multibody/gap/edge_gap.hpp"

#include <array>
#include <cmath>

namespace vps {
namespace {

constexpr int kHalvings = 4;  // of the way between two places above different faces, to find those that are neighbours

bool IsSameFace(const NearestFacet& a, const NearestFacet& b) {
  const glm::dvec3 e = glm::cross(a.normal, b.normal);
  return glm::dot(e, e) < kAlong;
}
bool MeetInAConvexEdge(const NearestFacet& a, const NearestFacet& b) {
  const auto is_below = [](const NearestFacet& one, const NearestFacet& other) {
    const glm::dvec3 middle = (one.corners[0] + one.corners[1] + one.corners[2]) / 3.0;
    return glm::dot(middle - other.corners[0], other.normal) < 0.0;
  };
  return is_below(a, b) && is_below(b, a);
}

// A piece of edge of S, seen from above, and the facets of G that are nearest to it.
class EdgePiece {
 public:
  EdgePiece(const FacetsAround& around, const PlaceInG& place) : around_(around), place_(place) {}

  // Below the place at `share` of the piece, from -1 to 1.
  [[nodiscard]] NearestFacet Below(double share) const {
    const double way = share * kEdgeOverlap * place_.reach;
    return around_.FindNearest(place_.p + way * place_.along + place_.back() * place_.inward,
                               place_.back() + SearchReach(place_.depth) + std::abs(way));
  }

  // Two facets below two places of the piece become those of two neighbours.
  void Narrow(double share_a, double share_b, NearestFacet* a, NearestFacet* b) const {
    for (int halving = 0; halving < kHalvings; ++halving) {
      const double middle = 0.5 * (share_a + share_b);
      const NearestFacet c = Below(middle);
      if (!c.is_found) break;
      const bool is_past = !IsSameFace(c, *a) && (IsSameFace(c, *b) || MeetInAConvexEdge(*a, c));
      *(is_past ? b : a) = c;
      (is_past ? share_b : share_a) = middle;
    }
  }

  // Over the edge in which the planes of a and b meet.
  [[nodiscard]] EdgeCrossing Over(const NearestFacet& a, const NearestFacet& b) const {
    const glm::dvec3& p = place_.p;
    const glm::dvec3 e = glm::cross(a.normal, b.normal);
    const glm::dvec3 across = glm::cross(place_.along, e);
    if (IsSameFace(a, b) || !MeetInAConvexEdge(a, b) || glm::dot(across, across) < kAlong * glm::dot(e, e)) return {};
    // A point of G's edge: q = p + (ha (b x e) + hb (e x a)) / e^2 with the planes' heights over p.
    const double ha = glm::dot(a.place - p, a.normal);
    const double hb = glm::dot(b.place - p, b.normal);
    const glm::dvec3 from_p = (ha * glm::cross(b.normal, e) + hb * glm::cross(e, a.normal)) / glm::dot(e, e);
    const double t = glm::dot(glm::cross(from_p, e), across) / glm::dot(across, across);
    glm::dvec3 n = across / glm::length(across);
    if (glm::dot(n, place_.inward) < 0.0) n = -n;
    const bool is_between = glm::dot(glm::cross(a.normal, n), e) >= 0.0 && glm::dot(glm::cross(n, b.normal), e) >= 0.0;
    if (std::abs(t) > place_.reach + kClear || !is_between) return {};
    const double height = glm::dot(t * place_.along - from_p, n);
    return {{true, p + t * place_.along, n, height}, glm::dot(a.normal, n) > glm::dot(b.normal, n) ? a : b, {}};
  }

 private:
  const FacetsAround& around_;
  const PlaceInG& place_;
};

}  // namespace

EdgeCrossing OverEdge(const FacetsAround& around, const PlaceInG& place) {
  const EdgePiece piece(around, place);
  const std::array<NearestFacet, 3> below{piece.Below(-1.0), piece.Below(0.0), piece.Below(1.0)};
  EdgeCrossing least{{}, {}, below[1]};
  for (std::size_t i = 0; i < 2; ++i) {
    NearestFacet a = below[i];
    NearestFacet b = below[i + 1];
    if (!a.is_found || !b.is_found || IsSameFace(a, b)) continue;
    piece.Narrow(static_cast<double>(i) - 1.0, static_cast<double>(i), &a, &b);
    const EdgeCrossing crossing = piece.Over(a, b);
    if (!crossing.gap.is_found || (least.gap.is_found && crossing.gap.height >= least.gap.height)) continue;
    least.gap = crossing.gap;
    least.face = crossing.face;
  }
  return least;
}

}  // namespace vps
