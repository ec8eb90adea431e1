#pragma once

#include "vps/field/nearest_facet.hpp"
#include "vps/multibody/gap/gap.hpp"

namespace vps {

// Pieces of an edge are searched beyond their ends: where an edge of G passes under the common end of two, each sees
// the faces on both sides of it. From as far as kClear above an edge of G both are equally near (not derived).
constexpr double kEdgeOverlap = 1.5;

// An edge of S over an edge of G: the gap, and the face of G whose normal is nearer to the gap's.
struct EdgeCrossing {
  Gap gap;
  NearestFacet face;
  NearestFacet below;  // the middle of S's piece of edge, also where there is no crossing
};

// Where a piece of a sharp edge of S passes over an edge of G: between two of its places that are above different faces
// of G, whose planes meet in G's edge. The normal is across both edges.
EdgeCrossing OverEdge(const FacetsAround& around, const PlaceInG& place);

}  // namespace vps
