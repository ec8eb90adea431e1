#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "vps/field/closest_triangle.hpp"
#include "vps/field/field_word.hpp"
#include "vps/field/triangle_rows.hpp"

namespace vps {

// What a cell at a crease becomes: one plane (a word), or a record of several.
struct CreaseFit {
  CellKind kind = CellKind::kPlane;
  std::array<std::uint32_t, kPlanesPerCrease> planes{};  // unused ones repeat the last
  float largest_error = 0.0f;                            // voxels, at the places tested
};

// Signed distance (voxels) and unit gradient at a place from its nearest triangle.
struct TangentPlane {
  float distance = 0.0f;
  glm::vec3 gradient{0.0f, 0.0f, 1.0f};
  bool is_over_face = false;  // the gradient is the triangle's normal
};
inline TangentPlane TangentOf(const TriangleField::Value& value) {
  return {static_cast<float>(value.distance), glm::vec3(value.gradient), false};
}

// The distance to a solid is convex around a convex edge (the largest of the faces' plane distances inside, a cone
// outside) and concave around a concave one, so it is the largest or smallest of its tangent planes; where edges of
// both kinds meet, it is the largest of smallest ones or the other way round. Tangents are taken from the exact
// distance to the `near` triangles at 23 places of the cell; those that leave the least error there are kept.
// `first_sample`: of the brick; `cell`: in the brick; `around`: signs known near the cell. Voxel units.
CreaseFit FitCrease(const TriangleField& field, std::span<const NearTriangle> near, const glm::dvec3& first_sample,
                    const glm::ivec3& cell, SettledSigns* around);

}  // namespace vps
