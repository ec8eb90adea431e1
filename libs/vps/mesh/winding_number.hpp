#pragma once

#include <vector>

#include "vps/mesh/box_tree.hpp"

namespace vps {

// How many times a surface winds around a point p [Jacobson et al. 2013]: 1 inside a closed outward mesh, 0 outside, 2
// where two solids of one mesh overlap; between these near holes.
//
//   w(p) = sum over triangles of solid angle / 4 pi,   of a far group  r . m / (4 pi |r|^3)
//
// with m the group's sum of area times normal [m^2] and r [m] from p to its centroid: one dipole [Barill et al. 2018].
// That moves the sum by less than 0.05, so that 0.5 separates inside from outside.
// Of a closed surface it is the number of crossings of a ray (CountRayCrossings): exact, and a search of one path
// through the tree; long thin triangles make the sum a search of most of it.
class WindingNumber {
 public:
  explicit WindingNumber(const TriangleMesh& mesh);

  [[nodiscard]] double At(const glm::dvec3& p) const;
  [[nodiscard]] bool IsInside(const glm::dvec3& p) const { return At(p) > 0.5; }

 private:
  struct Dipole {
    glm::dvec3 centre{0.0};     // mean of the triangles' centroids, weighted by area
    glm::dvec3 moment_m2{0.0};  // sum of area times normal
    double reach = 0.0;         // beyond this distance from the centre the dipole replaces the triangles
  };
  bool is_closed_;                                    // by edges with the same vertices (CountOpenEdges)
  std::vector<std::array<glm::dvec3, 3>> triangles_;  // in the tree's order
  BoxTree tree_;
  std::vector<Dipole> dipoles_;  // one for each node
};

// Signed solid angle W of a triangle a, b, c (relative to p) over 4 pi [Van Oosterom and Strackee 1983]:
//   tan(W / 2) = a . (b x c) / (|a||b||c| + (a . b)|c| + (b . c)|a| + (c . a)|b|).
double WindingOfTriangle(const std::array<glm::dvec3, 3>& triangle, const glm::dvec3& p);

}  // namespace vps
