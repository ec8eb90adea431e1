#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "vps/field/closest_triangle.hpp"
#include "vps/field/field_word.hpp"

namespace vps {

// What a cell at a crease becomes: one plane (a word), or a record of several.
struct CreaseFit {
  CellKind kind = CellKind::kPlane;
  std::array<std::uint32_t, kPlanesPerCrease> planes{};  // unused ones repeat the first
  float largest_error = 0.0f;                            // voxels, at the places tested
};

// The distance to a solid is convex around a convex edge (the largest of the faces' plane distances inside, a cone
// outside) and concave around a concave one, so it is the largest or smallest of its tangent planes; where edges of
// both kinds meet, it is the largest of smallest ones or the other way round. Tangents are taken from the exact
// distance at 23 places of the cell around `centre`; those that leave the least error there are kept. `triangles` are
// the nearest triangles of the cell and of its neighbours. Voxel units.
CreaseFit FitCrease(const TriangleField& field, std::span<const std::uint32_t> triangles, const glm::dvec3& centre);

}  // namespace vps
