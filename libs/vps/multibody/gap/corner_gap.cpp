#include "vps/multibody/gap/corner_gap.hpp"

#include <algorithm>
#include <cmath>

#include "vps/mesh/nearest_on_triangle.hpp"
#include "vps/sampling/nearest_piece.hpp"

namespace vps {
namespace {

// A corner of G is measured if a place of S is nearer to it than this [spacings]: on a square grid of places the
// farthest is half a diagonal away, 0.71; places are not on a grid (not derived).
constexpr double kAroundCorner = 2.0;

// A corner of G over a face of S, seen from a point that is clear of S's surface. The normal is that face's. Over an
// edge or a corner of S it is that of the face around whose plane the corner is highest above: in convex S of planes
// with heights h_k the corner is at max h_k.
Gap UnderFace(const GapScene& scene, const CornersBelow::Corner& corner) {
  const double voxel_m = scene.field.voxel_size_m;
  const double spacing = scene.S.spacing_m / voxel_m;
  double back = SearchReach(std::min(corner.height, 0.0));
  glm::dvec3 n = corner.n;
  for (int turn = 0; turn < kMostHops; ++turn) {
    const glm::dvec3 from_S = scene.InSample(corner.p - back * n);
    const NearestPiece piece = FindNearestPiece(scene.S.pieces, from_S, (2.0 * back + spacing) * voxel_m);
    if (!piece.is_found) return {};
    const glm::dvec3 before = n;
    n = -scene.X_GS.rotate(piece.outward);
    const glm::dvec3 p = (scene.X_GS * piece.place - scene.field.origin_m) / voxel_m;
    const double height = glm::dot(p - corner.p, n);
    if (turn > 0 && glm::dot(n, before) > 1.0 - 0.5 * kSlope * kSlope) return {true, corner.p + height * n, n, height};
    // No farther from S than is clear: from there the faces that meet under the corner do not look alike.
    back = std::max(-height, 0.0) + kClear;
  }
  return {};
}

bool IsNear(const FacetsAround::Facet& facet, const glm::dvec3& p, double reach) {
  const glm::dvec3 a = facet.corners[0] - p;
  const glm::dvec3 b = facet.corners[1] - p;
  const glm::dvec3 c = facet.corners[2] - p;
  const glm::dvec3 q = NearestOnTriangle(a, b, c, glm::cross(b - a, c - a)).place;
  return glm::dot(q, q) < reach * reach;
}

// The direction next to n in which G's corner can carry: all of G around it lies on or below the plane across it. On a
// flat part of G that is the face's normal, on a straight edge it is across the edge. Each way up is projected off, and
// the passes repeat because one projection may raise another way.
glm::dvec3 Carrying(const DistanceField& field, const glm::dvec3& corner, glm::dvec3 n, FacetsAround* around) {
  constexpr double kStep = 2.0 * static_cast<double>(kFacetStep);  // corners are rounded
  around->Gather(field.triangles(), corner, kStep);
  for (int pass = 0; pass < kMostHops; ++pass) {
    for (const FacetsAround::Facet& facet : around->facets()) {
      if (!IsNear(facet, corner, kStep)) continue;
      for (const glm::dvec3& other : facet.corners) {
        const glm::dvec3 way = other - corner;
        const double length = glm::length(way);
        const double up = glm::dot(way, n);
        if (up > kStep + kSlope * length) n = glm::normalize(n - up / (length * length) * way);
      }
    }
  }
  return n;
}

}  // namespace

void CornersBelow::Add(const GapScene& scene, const NearestFacet& facet, const PlaceInG& place) {
  const double reach = kAroundCorner * scene.S.spacing_m / scene.field.voxel_size_m;
  for (const glm::dvec3& corner : facet.corners) {
    const glm::dvec3 way = place.p - corner;
    const double height = glm::dot(way, place.inward);
    if (height >= kExactWithin || glm::dot(way, way) - height * height > reach * reach) continue;
    const auto* known = std::find_if(corners.begin(), corners.end(), [&](const Corner& c) { return c.p == corner; });
    if (known == corners.end()) corners.push_back({corner, place.inward, height});
  }
}

std::uint32_t NameOfCorner(const glm::dvec3& corner) {
  const glm::ivec3 steps(glm::round(corner / static_cast<double>(kFacetStep)));
  const auto hash = static_cast<std::uint32_t>(steps.x) * 73856093U ^ static_cast<std::uint32_t>(steps.y) * 19349663U ^
                    static_cast<std::uint32_t>(steps.z) * 83492791U;
  return hash | kCornerOfG;
}

Gap MeasureCorner(const GapScene& scene, const CornersBelow::Corner& corner, FacetsAround* around) {
  Gap gap = UnderFace(scene, corner);
  if (!gap.is_found || gap.height >= kExactWithin) return {};
  const glm::dvec3 n = Carrying(scene.field, corner.p, gap.n, around);
  const double cosine = glm::dot(n, gap.n);
  if (cosine < std::cos(Beside_rad(scene.S))) return {};
  gap.height /= cosine;  // to the plane of S's face, along n
  gap.n = n;
  gap.p = corner.p + gap.height * n;
  return gap;
}

}  // namespace vps
