#pragma once

#include "vps/sampling/surface_pieces.hpp"

namespace vps {

// The place of a surface that is nearest to a point. Mesh frame, metres.
struct NearestPiece {
  bool is_found = false;
  bool is_on_face = false;  // else on an edge or a corner of a piece
  glm::dvec3 place{0.0};
  glm::dvec3 outward{0.0};  // unit
};

// Of the pieces whose outer side the point is on. Not found: nothing within `reach_m`. Does not allocate.
NearestPiece FindNearestPiece(const SurfacePieces& pieces, const glm::dvec3& p, double reach_m) noexcept;

// The same; of pieces that meet at the nearest place, the one above whose plane q is highest.
NearestPiece FindNearestPiece(const SurfacePieces& pieces, const glm::dvec3& p, const glm::dvec3& q,
                              double reach_m) noexcept;

}  // namespace vps
