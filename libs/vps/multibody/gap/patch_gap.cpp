#include "vps/multibody/gap/patch_gap.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "vps/surface/nearest_place.hpp"

namespace vps {
namespace {

// Of a place in the plane of one of S's faces.
bool IsOnS(const GapScene& scene, const glm::dvec3& p, const glm::dvec3& inward_G) {
  const glm::dvec3 outside = scene.InSample(p - kClear * inward_G);
  return FindNearestPlace(*scene.S.surface, outside, outside, 1.01 * kClear * scene.field.voxel_size_m).is_found;
}

// From a place on a triangle straight up it, to its rim.
glm::dvec3 UpToRim(const NearestFacet& facet, const glm::dvec3& up) {
  const glm::dvec3 d = up - glm::dot(up, facet.normal) * facet.normal;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < 3; ++k) {
    const glm::dvec3& a = facet.corners[k];
    const glm::dvec3 out = glm::cross(facet.corners[(k + 1) % 3] - a, facet.normal);
    const double speed = glm::dot(d, out);
    if (speed > 0.0) least = std::min(least, std::max(glm::dot(a - facet.place, out), 0.0) / speed);
  }
  return std::isfinite(least) ? facet.place + least * d : facet.place;
}

// Where the patch slides to from what is below it now.
glm::dvec3 Up(const NearestFacet& facet, const glm::dvec3& inward) {
  if (facet.is_on_face) return UpToRim(facet, inward);
  glm::dvec3 to = facet.corners[0];
  for (const glm::dvec3& corner : facet.corners) {
    if (glm::dot(corner - to, inward) > 0.0) to = corner;
  }
  return to;
}

}  // namespace

Gap OverPatch(const GapScene& scene, const FacetsAround& around, const PlaceInG& place) {
  const glm::dvec3& p = place.p;
  const glm::dvec3& inward = place.inward;
  double back = place.back();
  glm::dvec3 way(0.0);
  glm::dvec3 inside(0.0);
  Gap gap;
  for (int hop = 0; hop < kMostHops; ++hop) {
    const NearestFacet facet =
        around.FindNearest(p + way + back * inward, back + place.reach + SearchReach(place.depth));
    if (!facet.is_found) return gap;
    const glm::dvec3 above = p + way + back * inward - facet.place;
    const bool is_right_above =
        facet.height > 0.0 && glm::dot(above, inward) > (1.0 - 0.5 * kSlope * kSlope) * glm::length(above);
    if (hop == 0 || (is_right_above && IsOnS(scene, p + way + inside, inward))) {
      // Over an edge or a corner right below, the normal is S's own.
      const bool is_own = is_right_above && !facet.is_on_face;
      gap = GapAlong(is_own ? inward : NormalTo(facet, above), facet, p + way);
    }
    const double rise = glm::dot(facet.normal, inward);
    if (is_right_above || rise < -kSlope) return gap;
    if (rise <= kSlope) inside = -2.0 * kClear * facet.normal;
    way = Up(facet, inward) - p;
    const double up = glm::dot(way, inward);
    back = std::max(up, 0.0) + kClear;
    way -= up * inward;
    if (glm::length(way) > place.reach) return gap;
  }
  return gap;
}

}  // namespace vps
