#pragma once

#include <span>

#include "vps/pointshell/pointshell.hpp"
#include "vps/tree/point_tree.hpp"

namespace vps {

// Bottom-up [VR-OOS, section 3]: the K = 4 closest points of a level become a cluster, the one nearest to the cluster's
// centre of mass its parent point; the parent points are the next level's points, until one is left. Spheres are the
// smallest that hold all descendant points.
// A cluster takes no point farther away than a few mean spacings of its level: the stragglers that greedy clustering
// leaves behind would otherwise make clusters as wide as the object. Such a cluster has fewer than four children.
PointTree BuildTree(const Pointshell& shell);

// Smallest sphere around points given as floats, exact up to rounding. Empty input: radius 0.
struct Sphere {
  glm::dvec3 centre{0.0};
  double radius = 0.0;
};
Sphere SmallestSphere(const float* x, const float* y, const float* z, std::size_t count);
Sphere SmallestSphere(std::span<const glm::vec3> points);

}  // namespace vps
