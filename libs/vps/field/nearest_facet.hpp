#pragma once

#include <array>
#include <glm/glm.hpp>

#include "core/fixed_vector.hpp"
#include "vps/field/distance_field.hpp"

namespace vps {

// The place of a field's own triangles that is nearest to a point. In voxels of the field.
struct NearestFacet {
  bool is_found = false;
  bool is_on_face = false;  // else on an edge or a corner
  glm::dvec3 place{0.0};
  glm::dvec3 normal{0.0};  // unit, outwards, of the triangle whose side the point is on
  double height = 0.0;     // distance, negative inside
  std::array<glm::dvec3, 3> corners{};
};

// Not found: nothing within `reach`, or the side of the nearest triangle is in doubt. Does not allocate.
NearestFacet FindNearestFacet(const Facets& facets, const glm::dvec3& p, double reach) noexcept;

// The triangles within a ball, gathered once for several searches in it. Does not allocate.
class FacetsAround {
 public:
  // Not derived: 36 KB; a ball with more is searched by the tree.
  static constexpr std::size_t kMost = 256;
  struct Facet {
    std::array<glm::dvec3, 3> corners;
    glm::dvec3 normal;
    double height = 0.0;  // of the plane over the origin, along the normal
    bool is_doubtful = false;
  };

  void Gather(const Facets& facets, const glm::dvec3& p, double radius) noexcept;
  // As FindNearestFacet, if the ball about p lies in the gathered one.
  [[nodiscard]] NearestFacet FindNearest(const glm::dvec3& p, double reach) const noexcept;
  // Empty if there were more than kMost.
  [[nodiscard]] const core::FixedVector<Facet, kMost>& facets() const { return near_; }

 private:
  const Facets* all_ = nullptr;
  core::FixedVector<Facet, kMost> near_;
  bool is_full_ = false;
};

}  // namespace vps
