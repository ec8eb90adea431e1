#pragma once

#include "core/fixed_vector.hpp"
#include "vps/field/nearest_facet.hpp"
#include "vps/multibody/gap/gap.hpp"

namespace vps {

// Corners of G that are measured: not derived, the time for a cycle bounds them.
constexpr std::size_t kMostCorners = 32;

// Corners of G's triangles below places of S.
struct CornersBelow {
  struct Corner {
    glm::dvec3 p;
    glm::dvec3 n;         // of the plane of S above which it is highest
    double height = 0.0;  // of that plane
  };
  core::FixedVector<Corner, kMostCorners> corners;

  // Those of a triangle that are near a place, or near its gap, and not far below.
  void Add(const GapScene& scene, const NearestFacet& facet, const PlaceInG& place, const Gap& gap);

 private:
  void Add(const GapScene& scene, const Corner& corner, const glm::dvec3& p);
};

// A corner of G has a name where a place of S has its number. Distinct corners of one surface hardly ever have the same
// name; if two do, they take turns in one slot.
std::uint32_t NameOfCorner(const glm::dvec3& corner);
constexpr std::uint32_t kCornerOfG = 1U << 31U;  // in the name of a corner of G
inline bool IsCornerOfG(std::uint32_t name) {
  return (name & kCornerOfG) != 0;
}

// A corner of G that has a gap.
struct MeasuredCorner {
  std::uint32_t name = 0;
  glm::dvec3 p{0.0};
  Gap gap;
};
using MeasuredCorners = core::FixedVector<MeasuredCorner, kMostCorners>;

// Null: none of that name.
inline const MeasuredCorner* FindCorner(const MeasuredCorners& corners, std::uint32_t name) {
  for (const MeasuredCorner& corner : corners) {
    if (corner.name == name) return &corner;
  }
  return nullptr;
}

// The gap between a corner of G and the face of S above it; not found if it is large, or if the corner cannot carry in
// that direction.
Gap MeasureCorner(const GapScene& scene, const CornersBelow::Corner& corner, FacetsAround* around);

}  // namespace vps
