#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "vps/field/settled_signs.hpp"
#include "vps/mesh/triangle_mesh.hpp"
#include "vps/mesh/trusted_normals.hpp"
#include "vps/mesh/wide_box_tree.hpp"
#include "vps/mesh/winding_number.hpp"

namespace vps {

// What tells inside from outside.
enum class Signs {
  kNormals,            // of the closest feature: for a simple solid (IsSimpleSolid)
  kWinding,            // the winding number, asked where no place around settles it
  kWindingEverywhere,  // the winding number, asked everywhere: the reference of tests
};

struct ClosestFeature {
  glm::dvec3 point{0.0};
  double squared_distance = 1e300;
  std::uint8_t feature = 0;  // 0-2 corner, 3-5 edge (0-1, 1-2, 2-0), 6 face
};

// A mesh prepared for closest-point queries with a sign. Lengths are those of the mesh given.
//
// The sign comes from the angle-weighted pseudonormal of the closest feature (Baerentzen and Aanaes 2005), which is
// exact for a closed, consistently oriented surface without self-intersections. Else (Signs) it comes from the winding
// number, which also holds for solids that overlap or pass through themselves, and takes longer.
class TriangleField {
 public:
  explicit TriangleField(const TriangleMesh& mesh, Signs signs = Signs::kNormals, core::ParallelFor* workers = nullptr);

  [[nodiscard]] std::size_t num_triangles() const { return indices_.size(); }
  [[nodiscard]] std::array<glm::dvec3, 3> corners(std::uint32_t triangle) const {
    const auto& [a, b, c] = indices_[triangle];
    return {vertices_[a], vertices_[b], vertices_[c]};
  }

  // Whether the side of the nearest face on which a point lies is its sign: no winding number is needed.
  [[nodiscard]] bool side_is_sign() const { return !winding_; }
  // The same of one face: true also where the winding number agrees with its normal (FindTrustedNormals).
  [[nodiscard]] bool side_is_sign(std::uint32_t triangle) const { return !winding_ || is_trusted_[triangle] != 0; }
  // Whether signs by the winding number spread from place to place (SettledSigns): no edge is open. Not where
  // Signs::kWindingEverywhere forbids it.
  [[nodiscard]] bool signs_spread() const { return signs_spread_; }
  // Unit, out of the solid; 0 when the triangle has no area.
  [[nodiscard]] const glm::dvec3& normal(std::uint32_t triangle) const { return normals_[triangle]; }
  // Of the triangle beyond the edge from corner k to k + 1, about unit; the sum of all where there are several.
  [[nodiscard]] glm::dvec3 neighbour_normal(std::uint32_t triangle, int k) const {
    return glm::dvec3(edge_normals_[triangle][static_cast<std::size_t>(k)]) - normals_[triangle];
  }

  // Of one triangle.
  [[nodiscard]] ClosestFeature Closest(std::uint32_t triangle, const glm::dvec3& p) const;
  // Of all; `triangle` holds a guess on entry (any valid index; a near one is faster) and the winner on return.
  [[nodiscard]] ClosestFeature ClosestOfAll(const glm::dvec3& p, std::uint32_t* triangle) const;
  // The closest of those nearer than `limit_m`; none: no triangle is. Adds the number of triangles looked at.
  [[nodiscard]] std::optional<ClosestFeature> ClosestWithin(const glm::dvec3& p, double limit_m,
                                                            std::size_t* num_tests) const;

  // Signed distance (negative inside) and unit gradient (out of the solid) at p from its closest feature.
  struct Value {
    double distance = 0.0;
    glm::dvec3 gradient{0.0, 0.0, 1.0};
  };
  [[nodiscard]] Value SignedValue(std::uint32_t triangle, const ClosestFeature& closest, const glm::dvec3& p) const;
  // The same, with the sign found from places `around` where it can be; p becomes one of them.
  [[nodiscard]] Value SignedValue(std::uint32_t triangle, const ClosestFeature& closest, const glm::dvec3& p,
                                  SettledSigns* around) const;
  // The same where the sign is known: -1 inside, 1 outside.
  [[nodiscard]] Value ValueWithSign(std::uint32_t triangle, const ClosestFeature& closest, const glm::dvec3& p,
                                    double sign) const;
  // Of the side of the closest feature on which p lies; of the winding number at p.
  [[nodiscard]] double SignOfSide(std::uint32_t triangle, const ClosestFeature& closest, const glm::dvec3& p) const;
  [[nodiscard]] double SignOfWinding(const glm::dvec3& p) const { return winding_->IsInside(p) ? -1.0 : 1.0; }

 private:
  [[nodiscard]] glm::dvec3 PseudoNormal(std::uint32_t triangle, std::uint8_t feature) const;

  std::optional<WindingNumber> winding_;
  bool signs_spread_ = false;
  std::vector<std::uint8_t> is_trusted_;  // of each triangle: its normal is as good as the winding number
  std::vector<glm::dvec3> vertices_;
  std::vector<std::array<std::uint32_t, 3>> indices_;
  std::vector<glm::dvec3> normals_;                     // unit, per triangle; 0 when it has no area
  std::vector<glm::dvec3> vertex_normals_;              // angle-weighted sums
  std::vector<std::array<glm::vec3, 3>> edge_normals_;  // sums of the faces'
  WideBoxTree tree_;                                    // of the triangles
};

}  // namespace vps
