#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/parallel_for.hpp"
#include "vps/mesh/triangle_mesh.hpp"

namespace vps {

struct Crossing {
  std::uint32_t a = 0, b = 0;  // triangles, a < b
  glm::dvec3 p_m{0.0};         // a point that both share
};

// Pairs of triangles that pass through each other, in order of their numbers: an edge of one pierces the inside of the
// other. Neighbours along an edge, contacts and faces that lie in one plane do not count. The search ends with
// `max_crossings`.
std::vector<Crossing> FindCrossings(const TriangleMesh& mesh, std::size_t max_crossings,
                                    core::ParallelFor* workers = nullptr);

// Of each triangle: 1 where it crosses another one or overlaps one in its plane, as where a part of an assembly stands
// on another. Its normal does not determine inside and outside there.
std::vector<std::uint8_t> FindIntersectingTriangles(const TriangleMesh& mesh, core::ParallelFor* workers = nullptr);
// Whether any is.
bool HasSelfIntersection(const TriangleMesh& mesh, core::ParallelFor* workers = nullptr);

}  // namespace vps
