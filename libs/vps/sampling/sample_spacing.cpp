#include "vps/sampling/sample_spacing.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vps {
namespace {

// The boxes of triangles without area are those of their edges and corners.
BoxTree TreeOf(const std::vector<std::array<glm::dvec3, 2>>& segments) {
  TriangleMesh mesh;
  for (const auto& [a, b] : segments) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(a);
    mesh.vertices.push_back(b);
    mesh.triangles.push_back({first, first + 1, first + 1});
  }
  return BuildBoxTree(mesh);
}

}  // namespace

// Numbers of points, for spacings c at corners, e at edges and f on faces [m]: the integral of dA / h^2.
// On both sides of an edge of length l, beyond the even ones: at distance x the spacing is max(e, x) up to f, so
//   2 l [int_0^e dx / e^2 + int_e^f dx / x^2 - f / f^2] = 4 l (1 / e - 1 / f).
// Around a corner of three faces of 90 degrees, at distance x with spacing x / 2 from 2 c to 2 e:
//   3 [pi / 4 (2 c)^2 / c^2 + int pi / 2 x dx / (x / 2)^2] = 3 pi (1 + 2 ln(e / c)).
// Corners are graded while they take less than a quarter of the share of edges (not derived).
SampleSpacing::SampleSpacing(const TriangleMesh& mesh, double area_m2, std::uint32_t num_points)
    : sharp_(FindSharpEdges(mesh)) {
  const double wanted = num_points;
  const double corner_points =
      3.0 * M_PI * (1.0 - 2.0 * std::log(kFinestCorner)) * static_cast<double>(sharp_.corners.size());
  const bool has_corners = corner_points < 0.25 * kEdgeShare * wanted;
  double at_edges = kEdgeShare * wanted;
  // As few points at edges as the finest spacing needs; fewer there leaves more for faces, which makes those finer.
  for (int i = 0; i < 20; ++i) {
    face_m_ = std::sqrt(area_m2 / (wanted - at_edges));
    const double finest =
        4.0 * sharp_.length_m * (1.0 / (kFinestEdge * face_m_) - 1.0 / face_m_) + (has_corners ? corner_points : 0.0);
    at_edges = std::min(kEdgeShare * wanted, finest);
  }
  const double spent = std::max(at_edges - (has_corners ? corner_points : 0.0), 0.0);
  edge_m_ = sharp_.length_m > 0.0 ? 1.0 / (spent / (4.0 * sharp_.length_m) + 1.0 / face_m_) : face_m_;
  corner_m_ = has_corners ? kFinestCorner * edge_m_ : edge_m_;
  segment_tree_ = TreeOf(sharp_.segments);
  std::vector<std::array<glm::dvec3, 2>> corners;
  for (const glm::dvec3& p : sharp_.corners) corners.push_back({p, p});
  corner_tree_ = TreeOf(corners);
}

SampleSpacing::Nearby SampleSpacing::Around(const Box& box) const {
  Nearby nearby;
  const Box around{box.lower - face_m_, box.upper + face_m_};
  ForOverlapping(segment_tree_, around, [&](std::uint32_t i) { nearby.segments.push_back(i); });
  const Box closer{box.lower - 2.0 * edge_m_, box.upper + 2.0 * edge_m_};
  ForOverlapping(corner_tree_, closer, [&](std::uint32_t i) { nearby.corners.push_back(i); });
  return nearby;
}

// For q within the radius r of the centre c,  d_i(q) >= d_i(c) - r  and  min d(q) <= min d(c) + r:  no q is nearest to
// what is 2 r farther from c than the nearest.
SampleSpacing::Nearby SampleSpacing::Narrow(const Nearby& nearby, const glm::dvec3& centre, double radius_m,
                                            const Distances& distances) const {
  constexpr double kPad = 1.0 + 1e-9;  // against rounding
  const double edge_m = std::min(face_m_ + radius_m, kPad * (distances.edge_m + 2.0 * radius_m));
  const double corner_m = std::min(2.0 * edge_m_ + radius_m, kPad * (distances.corner_m + 2.0 * radius_m));
  Nearby narrow;
  for (const std::uint32_t i : nearby.segments) {
    if (SquaredSegmentDistance(i, centre) < edge_m * edge_m) narrow.segments.push_back(i);
  }
  for (const std::uint32_t i : nearby.corners) {
    if (glm::length(sharp_.corners[i] - centre) < corner_m) narrow.corners.push_back(i);
  }
  return narrow;
}

SampleSpacing::Distances SampleSpacing::To(const glm::dvec3& p, const Nearby& nearby) const {
  double edge_m2 = std::numeric_limits<double>::infinity();
  for (const std::uint32_t i : nearby.segments) edge_m2 = std::min(edge_m2, SquaredSegmentDistance(i, p));
  double corner_m2 = std::numeric_limits<double>::infinity();
  for (const std::uint32_t i : nearby.corners) {
    const glm::dvec3 r = sharp_.corners[i] - p;
    corner_m2 = std::min(corner_m2, glm::dot(r, r));
  }
  return {std::sqrt(edge_m2), std::sqrt(corner_m2)};
}

double SampleSpacing::At(const Distances& distances, double less_m) const {
  const double to_edge_m = std::min(2.0 * face_m_ + less_m, distances.edge_m);
  const double to_corner_m = std::min(4.0 * edge_m_ + less_m, distances.corner_m);
  const double floor_m = std::clamp(0.5 * (to_corner_m - less_m), corner_m_, edge_m_);
  return std::clamp(to_edge_m - less_m, floor_m, face_m_);
}

double SampleSpacing::SquaredSegmentDistance(std::uint32_t segment, const glm::dvec3& p) const {
  const auto& [a, b] = sharp_.segments[segment];
  const glm::dvec3 along = b - a;
  const double t = std::clamp(glm::dot(p - a, along) / glm::dot(along, along), 0.0, 1.0);
  const glm::dvec3 r = p - (a + t * along);
  return glm::dot(r, r);
}

}  // namespace vps
