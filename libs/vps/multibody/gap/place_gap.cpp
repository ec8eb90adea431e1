#include "vps/multibody/gap/place_gap.hpp"

#include <cmath>

#include "vps/multibody/gap/edge_gap.hpp"
#include "vps/multibody/gap/patch_gap.hpp"
#include "vps/sampling/touch_points.hpp"

namespace vps {
namespace {

// By the field a normal is less sure than by facets: one that is farther outside a place's own than this is not its
// own.
constexpr double kBesideByField = kSharpAngle_deg * 3.14159265358979 / 180.0;

Gap ByField(const DistanceField& field, const glm::dvec3& p) {
  const FieldSample sample = SampleField(field, glm::vec3(p));
  return {true, p, glm::normalize(glm::dvec3(sample.gradient)), static_cast<double>(sample.distance)};
}

// By which the gap can fall along S away from its place.
double Slope(const TouchPlace& place, const glm::dvec3& n, const glm::dvec3& inward_G, const glm::dvec3& along_G) {
  if (place.kind == TouchPlace::Kind::kEdge) return std::abs(glm::dot(n, along_G));
  return place.kind == TouchPlace::Kind::kFace ? glm::length(glm::cross(n, inward_G)) : 0.0;
}

// What is below a place, and of an edge, where it crosses one of G.
EdgeCrossing Below(const FacetsAround& around, const PlaceInG& place) {
  if (place.kind == TouchPlace::Kind::kEdge) return OverEdge(around, place);
  const double reach = place.back() + SearchReach(place.depth);
  return {{}, {}, around.FindNearest(place.p + place.back() * place.inward, reach)};
}

// Of a place in a groove of G, from the other face than `face`. In a groove each of the two is above the other's plane:
// the far side of a thin wall, and what is behind it, are not.
Gap OverOtherFace(const PlaceInG& place, const Gap& least, const NearestFacet& face, FacetsAround* around) {
  constexpr double kOnPlane = kSamePlace;
  around->LeaveOut(face);
  const EdgeCrossing other = Below(*around, place);
  Gap gap = other.gap;
  if (!gap.is_found) {
    const NearestFacet& facet = other.below;
    if (!facet.is_found || !facet.is_on_face) return {};
    gap = GapAlong(facet.normal, facet, place.p);
  }
  const glm::dvec3 across = gap.OnG() - least.OnG();
  const glm::dvec3 turn = glm::cross(gap.n, least.n);
  gap.is_found =
      glm::dot(turn, turn) > kAlong && glm::dot(across, least.n) > -kOnPlane && glm::dot(across, gap.n) < kOnPlane;
  return gap;
}

// How far from the place the facets are that its kind asks for, and the surface beneath.
double Surroundings(const PlaceInG& place) {
  const double around_place = place.back() + SearchReach(place.depth);
  switch (place.kind) {
    case TouchPlace::Kind::kFace:
      return 2.0 * place.reach + around_place;
    case TouchPlace::Kind::kEdge:
      return 2.0 * kEdgeOverlap * place.reach + place.back() + around_place;
    default:
      return place.back() + around_place;
  }
}

// By G's triangles.
Gaps ByFacets(const GapScene& scene, const PlaceInG& place, FacetsAround* around, CornersBelow* below) {
  around->Gather(scene.field.triangles(), place.p, Surroundings(place));
  const bool is_flat = place.kind == TouchPlace::Kind::kFace;
  const EdgeCrossing crossing = Below(*around, place);
  const NearestFacet& facet = crossing.below;
  const NearestFacet& face = crossing.gap.is_found ? crossing.face : facet;
  Gaps gaps;
  gaps.least = is_flat ? OverPatch(scene, *around, place) : crossing.gap;
  if (!is_flat) {
    if (!facet.is_found) return gaps;
    if (!gaps.least.is_found) {  // a corner of S, or a piece of edge between its crossings
      const glm::dvec3 above = place.p + place.back() * place.inward - facet.place;
      gaps.least = GapAlong(NormalTo(facet, above), facet, place.p);
    }
    below->Add(scene, facet, place, gaps.least);
  }
  if (gaps.least.is_found && face.is_found && gaps.least.height < kExactWithin) {
    gaps.other = OverOtherFace(place, gaps.least, face, around);
  }
  return gaps;
}

}  // namespace

Gaps MeasurePlace(const GapScene& scene, std::uint32_t point, double depth, FacetsAround* around, CornersBelow* below) {
  const TouchPlace& touch = scene.S.places[point];
  const PlaceInG place{touch.kind,
                       scene.InVoxels(scene.PointAt(point)),
                       scene.X_GS.rotate(glm::dvec3(touch.inward)),
                       scene.X_GS.rotate(glm::dvec3(touch.along)),
                       static_cast<double>(touch.reach_m) / scene.field.voxel_size_m,
                       depth};
  Gaps gaps{ByField(scene.field, place.p), {}};
  double beside = kBesideByField;
  const double fall = Slope(touch, gaps.least.n, place.inward, place.along) * static_cast<double>(touch.reach_m) /
                      scene.field.voxel_size_m;
  if (gaps.least.height - fall < kExactWithin) {
    const Gaps exact = ByFacets(scene, place, around, below);
    if (exact.least.is_found) {
      gaps = exact;
      beside = Beside_rad(scene.S);
    }
  }
  // Else it cannot be what touches there: S reaches farther beside it, or G ends before.
  const auto belongs = [&](const Gap& gap) {
    const double off = std::atan2(glm::length(glm::cross(gap.n, place.inward)), glm::dot(gap.n, place.inward));
    return off < static_cast<double>(touch.cone_rad) + beside;
  };
  gaps.least.is_found = belongs(gaps.least);
  gaps.other.is_found = gaps.other.is_found && belongs(gaps.other);
  if (!gaps.least.is_found) std::swap(gaps.least, gaps.other);
  return gaps;
}

}  // namespace vps
