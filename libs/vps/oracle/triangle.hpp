#pragma once

#include <array>
#include <glm/glm.hpp>

namespace vps::oracle {

using Triangle = std::array<glm::dvec3, 3>;

// Closest points of two segments (p0, p1) and (q0, q1): squared distance.
double SquaredSegmentDistance(const glm::dvec3& p0, const glm::dvec3& p1, const glm::dvec3& q0, const glm::dvec3& q1);

// Closest point of a triangle to p, by the Voronoi regions of its corners, edges and face. A triangle without area
// counts as its edges.
glm::dvec3 NearestPointOnTriangle(const glm::dvec3& p, const Triangle& t);

// Do they share a point? Coplanar overlap counts when an edge runs into the other triangle's face within rounding.
bool TrianglesMeet(const Triangle& s, const Triangle& t);

// 0 when they meet, else the least of the six corner-to-face and nine edge-to-edge distances.
double TriangleDistance(const Triangle& s, const Triangle& t);

}  // namespace vps::oracle
