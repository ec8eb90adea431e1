#include "vps/multibody/gap/corner_gap.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "vps/mesh/nearest_on_triangle.hpp"
#include "vps/surface/nearest_place.hpp"

namespace vps {
namespace {

// A corner of G is measured if a place of S is nearer to it than this [spacings]: on a square grid of places the
// farthest is half a diagonal away, 0.71; places are not on a grid (not derived).
constexpr double kAroundCorner = 2.0;

constexpr double kStep = 2.0 * kSamePlace;

// A corner of G over a face of S, seen along n from a point that is clear of S's surface. The normal is that face's.
// Where faces of S meet over the corner it is that of the one above whose plane the corner is highest: of convex S with
// planes at heights h_k it is at max h_k.
Gap UnderFace(const GapScene& scene, const CornersBelow::Corner& corner, glm::dvec3 n) {
  const double voxel_m = scene.field.voxel_size_m;
  const double spacing = scene.S.spacing_m / voxel_m;
  const glm::dvec3 corner_S = scene.InSample(corner.p);
  double back = SearchReach(std::min(corner.height, 0.0));
  for (int turn = 0; turn < kMostHops; ++turn) {
    const glm::dvec3 from_S = scene.InSample(corner.p - back * n);
    const NearestPlace piece = FindNearestPlace(*scene.S.surface, from_S, corner_S, (2.0 * back + spacing) * voxel_m);
    if (!piece.is_found) return {};
    const glm::dvec3 before = n;
    n = -scene.X_GS.rotate(piece.outward);
    const glm::dvec3 p = (scene.X_GS * piece.place - scene.field.origin_m) / voxel_m;
    const double height = glm::dot(p - corner.p, n);
    if (turn > 0 && glm::dot(n, before) > 1.0 - 0.5 * kSlope * kSlope) return {true, corner.p + height * n, n, height};
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

// Of the faces of G around its corner, by their angles there.
glm::dvec3 MeanNormal(const FacetsAround& around, const glm::dvec3& corner) {
  glm::dvec3 sum(0.0);
  for (const FacetsAround::Facet& facet : around.facets()) {
    if (!IsNear(facet, corner, kStep)) continue;
    const auto& [a, b, c] = facet.corners;
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    double angle = std::numbers::pi;  // in the middle of a side
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::dvec3& at = facet.corners[k];
      if (glm::length(at - corner) > kStep) continue;
      const glm::dvec3 u = facet.corners[(k + 1) % 3] - at;
      const glm::dvec3 v = facet.corners[(k + 2) % 3] - at;
      angle = std::atan2(glm::length(glm::cross(u, v)), glm::dot(u, v));
    }
    const double length = glm::length(normal);
    if (length > 0.0) sum += angle / length * normal;
  }
  return sum;
}

// The direction next to n in which G's corner can carry: all of G around it lies on or below the plane across it. On a
// flat part of G that is the face's normal, on a straight edge it is across the edge. Each way up is projected off, and
// the passes repeat because one projection may raise another way.
glm::dvec3 Carrying(const FacetsAround& around, const glm::dvec3& corner, glm::dvec3 n) {
  for (int pass = 0; pass < kMostHops; ++pass) {
    for (const FacetsAround::Facet& facet : around.facets()) {
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

void CornersBelow::Add(const GapScene& scene, const NearestFacet& facet, const PlaceInG& place, const Gap& gap) {
  for (const glm::dvec3& corner : facet.corners) {
    Add(scene, {corner, place.inward, glm::dot(place.p - corner, place.inward)}, place.p);
    if (gap.is_found) Add(scene, {corner, gap.n, glm::dot(gap.p - corner, gap.n)}, gap.p);
  }
}

// Of several places of S over a corner the one above whose plane it is highest, as in UnderFace.
void CornersBelow::Add(const GapScene& scene, const Corner& corner, const glm::dvec3& p) {
  const double reach = kAroundCorner * scene.S.spacing_m / scene.field.voxel_size_m;
  const glm::dvec3 way = p - corner.p;
  if (corner.height >= kExactWithin || glm::dot(way, way) > reach * reach) return;
  auto* const known = std::find_if(corners.begin(), corners.end(), [&](const Corner& c) { return c.p == corner.p; });
  if (known == corners.end()) {
    corners.push_back(corner);
  } else if (corner.height > known->height) {
    *known = corner;
  }
}

std::uint32_t NameOfCorner(const glm::dvec3& corner) {
  const glm::ivec3 steps(glm::round(corner / kSamePlace));
  const auto hash = static_cast<std::uint32_t>(steps.x) * 73856093U ^ static_cast<std::uint32_t>(steps.y) * 19349663U ^
                    static_cast<std::uint32_t>(steps.z) * 83492791U;
  return hash | kCornerOfG;
}

Gap MeasureCorner(const GapScene& scene, const CornersBelow::Corner& corner, FacetsAround* around) {
  around->Gather(scene.field.triangles(), corner.p, kStep);
  const glm::dvec3 sum = MeanNormal(*around, corner.p);
  const bool is_known = glm::length(sum) > kSlope;  // else more faces than are gathered meet there
  Gap gap = UnderFace(scene, corner, is_known ? glm::normalize(sum) : corner.n);
  if (!gap.is_found || gap.height >= kExactWithin) return {};
  const glm::dvec3 n = Carrying(*around, corner.p, gap.n);
  const double cosine = glm::dot(n, gap.n);
  if (cosine < std::cos(Beside_rad(scene.S))) return {};
  gap.height /= cosine;  // to the plane of S's face, along n
  gap.n = n;
  gap.p = corner.p + gap.height * n;
  return gap;
}

}  // namespace vps
