#include "vps/sampling/sample_spacing.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace vps {
namespace {

std::vector<std::array<glm::dvec3, 2>> AsSegments(const std::vector<glm::dvec3>& points) {
  std::vector<std::array<glm::dvec3, 2>> segments;
  segments.reserve(points.size());
  for (const glm::dvec3& p : points) segments.push_back({p, p});
  return segments;
}

}  // namespace

// Numbers of points, for spacings c at corners, e at edges and f on faces [m]: the integral of dA / h^2.
// On both sides of an edge of length l, beyond the even ones: at distance x the spacing is max(e, x) up to f, so
//   2 l [int_0^e dx / e^2 + int_e^f dx / x^2 - f / f^2] = 4 l (1 / e - 1 / f).
// Around a corner of three faces of 90 degrees, at distance x with spacing x / 2 from 2 c to 2 e:
//   3 [pi / 4 (2 c)^2 / c^2 + int pi / 2 x dx / (x / 2)^2] = 3 pi (1 + 2 ln(e / c)).
// Corners are graded while they take less than a quarter of the share of edges (not derived).
SampleSpacing::SampleSpacing(const SharpEdges& sharp, double area_m2, std::uint32_t num_points)
    : edges_(sharp.segments), corners_(AsSegments(sharp.corners)) {
  const double wanted = num_points;
  const double corner_points =
      3.0 * M_PI * (1.0 - 2.0 * std::log(kFinestCorner)) * static_cast<double>(sharp.corners.size());
  const bool has_corners = corner_points < 0.25 * kEdgeShare * wanted;
  double at_edges = kEdgeShare * wanted;
  // As few points at edges as the finest spacing needs; fewer there leaves more for faces, which makes those finer.
  for (int i = 0; i < 20; ++i) {
    face_m_ = std::sqrt(area_m2 / (wanted - at_edges));
    const double finest =
        4.0 * sharp.length_m * (1.0 / (kFinestEdge * face_m_) - 1.0 / face_m_) + (has_corners ? corner_points : 0.0);
    at_edges = std::min(kEdgeShare * wanted, finest);
  }
  const double spent = std::max(at_edges - (has_corners ? corner_points : 0.0), 0.0);
  edge_m_ = sharp.length_m > 0.0 ? 1.0 / (spent / (4.0 * sharp.length_m) + 1.0 / face_m_) : face_m_;
  corner_m_ = has_corners ? kFinestCorner * edge_m_ : edge_m_;
}

SampleSpacing::SampleSpacing(const TriangleMesh& mesh, double area_m2, std::uint32_t num_points)
    : SampleSpacing(FindSharpEdges(mesh), area_m2, num_points) {}

SampleSpacing::Nearby SampleSpacing::Around(const Box& box) const {
  return {edges_.Around({box.lower - face_m_, box.upper + face_m_}),
          corners_.Around({box.lower - 2.0 * edge_m_, box.upper + 2.0 * edge_m_})};
}

// For q within the radius r of the centre c,  d_i(q) >= d_i(c) - r  and  min d(q) <= min d(c) + r:  no q is nearest to
// what is 2 r farther from c than the nearest.
SampleSpacing::Nearby SampleSpacing::Narrow(const Nearby& nearby, const glm::dvec3& centre, double radius_m,
                                            const Distances& distances) const {
  constexpr double kPad = 1.0 + 1e-9;  // against rounding
  const double edge_m = std::min(face_m_ + radius_m, kPad * (distances.edge_m + 2.0 * radius_m));
  const double corner_m = std::min(2.0 * edge_m_ + radius_m, kPad * (distances.corner_m + 2.0 * radius_m));
  return {edges_.Narrow(nearby.edges, centre, edge_m), corners_.Narrow(nearby.corners, centre, corner_m)};
}

// Narrow() keeps what is nearest to a place of the piece and nearer than the reach of At(): the spacing of faces, and
// twice that of edges. From a radius beyond that reach on, At() gives the same for all distances.
SampleSpacing::Distances SampleSpacing::To(const glm::dvec3& p, const Nearby& nearby, double radius_m) const {
  constexpr double kLess = 1.0 - 1e-9;  // against rounding
  constexpr double kMore = 1.0 + 1e-9;
  const auto to = [&](const SegmentTree& tree, const SegmentTree::Nearby& near, double reach_m) {
    return tree.Distance_m(p, near, kLess * reach_m, kMore * (reach_m + radius_m));
  };
  return {to(edges_, nearby.edges, face_m_), to(corners_, nearby.corners, 2.0 * edge_m_)};
}

double SampleSpacing::At(const Distances& distances, double less_m) const {
  const double to_edge_m = std::min(2.0 * face_m_ + less_m, distances.edge_m);
  const double to_corner_m = std::min(4.0 * edge_m_ + less_m, distances.corner_m);
  const double floor_m = std::clamp(0.5 * (to_corner_m - less_m), corner_m_, edge_m_);
  return std::clamp(to_edge_m - less_m, floor_m, face_m_);
}

}  // namespace vps
