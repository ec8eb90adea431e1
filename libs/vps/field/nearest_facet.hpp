#pragma once

#include <array>
#include <glm/glm.hpp>
#include <span>

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

// The triangles around a ball, gathered once for several searches in it. Does not allocate.
class FacetsAround {
 public:
  // Not derived: 26 KB; a ball with more is searched by the tree.
  static constexpr std::size_t kMost = 256;
  struct Facet {
    std::array<glm::dvec3, 3> corners;
    bool is_doubtful = false;
  };

  // All that come as near to p as `radius`, and some others.
  void Gather(const Facets& facets, const glm::dvec3& p, double radius) noexcept;
  // As FindNearestFacet, if the ball about p lies in the gathered one.
  [[nodiscard]] NearestFacet FindNearest(const glm::dvec3& p, double reach) const noexcept;
  // Drops those in the plane of a face, until the next Gather.
  void LeaveOut(const NearestFacet& face) noexcept;
  [[nodiscard]] std::span<const Facet> facets() const { return {near_.data(), count_}; }
  // There were more than kMost, and there are none.
  [[nodiscard]] bool is_full() const { return is_full_; }

 private:
  using Lane = std::array<float, kMost>;

  void Add(const Facet& facet);
  void FillUp();

  const Facets* all_ = nullptr;
  glm::dvec3 middle_{0.0};
  std::size_t count_ = 0;
  bool is_full_ = false;
  std::array<Facet, kMost> near_;
  std::array<Lane, 3> low_, high_;  // boxes, from middle_; up to a multiple of four far away
};

}  // namespace vps
